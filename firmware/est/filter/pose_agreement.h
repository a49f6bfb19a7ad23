// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/core/pose.h"
#include "firmware/core/time.h"
#include "firmware/est/filter/units.h"
#include "firmware/model/vehicle.h"

namespace m100::est {

/// A sequence of poses in which each pose agrees with the one before: their distance is at most 30 mm, plus 6 m/s times
/// the time between their captures, plus three sigmas of the noise that the sender states for both poses. The
/// observer's state plays no part.
template <typename Real>
class PoseAgreement {
 public:
  using Vector3 = core::Vector<Real, 3>;

  /// @returns whether the pose agrees with the one before it; if not, the pose begins a new row
  bool add(const core::Pose<Real>& pose, core::TimePoint now) {
    const double between_s = core::seconds<double>(since_last_ - pose.age(now));
    const Real noise_m = Real(3) * core::sqrt((pose.position_variance_m2 + last_.position_variance_m2).sum());
    const Real way_m = static_cast<Real>(kAgreement_m + kMaxSpeed_m_s * (between_s > 0.0 ? between_s : 0.0)) + noise_m;
    const Vector3 moved = pose.position_w_m - last_.position_w_m;
    const bool follows = count_ > 0 && moved.squaredNorm() <= way_m * way_m;
    count_ = follows ? count_ + 1 : 1;
    last_ = pose;
    came_until_ = now;
    since_last_ = pose.age(now);
    if (!follows) {
      first_ = pose;
      came_since_ = now;
      since_first_ = pose.age(now);
    }
    return follows;
  }
  /// The present velocity: the mean velocity from the first pose of the row to this one, plus what the tilt has added
  /// since the middle of that time. Metres per unit of time.
  Vector3 velocity(const core::Pose<Real>& pose, core::TimePoint now, Real tilt_x_rad, Real tilt_y_rad) const {
    const Real span_s = core::seconds<Real>(since_first_ - pose.age(now));
    constexpr Real kGravity = static_cast<Real>(model::kGravity_m_s2);
    const Vector3 acceleration{kGravity * core::tan(tilt_x_rad), -kGravity * core::tan(tilt_y_rad), Real(0)};
    const Real later_s = Real(0.5) * span_s + core::seconds<Real>(pose.age(now));  // from the middle of the span to now
    const Vector3 velocity = (pose.position_w_m - first_.position_w_m) / span_s + acceleration * later_s;
    return velocity * static_cast<Real>(kTimeUnit_s);
  }
  void end_row() { count_ = 0; }
  std::uint32_t count() const { return count_; }
  /// From the capture of the row's first pose to that of this one.
  core::Duration span(const core::Pose<Real>& pose, core::TimePoint now) const { return since_first_ - pose.age(now); }
  /// Time from the arrival of the row's first pose to that of its last.
  core::Duration lasted() const { return count_ > 1 ? came_until_ - came_since_ : core::Duration{0}; }
  core::Duration& since_last() { return since_last_; }
  core::Duration& since_first() { return since_first_; }

 private:
  static constexpr double kMaxSpeed_m_s = 6.0;
  static constexpr double kAgreement_m = 0.03;

  std::uint32_t count_ = 0;
  core::Pose<Real> last_{};
  core::Pose<Real> first_{};
  core::Duration since_last_{0};  ///< since the capture of last_
  core::Duration since_first_{0};
  core::TimePoint came_since_{};
  core::TimePoint came_until_{};
};

}  // namespace m100::est
