// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/core/pose.h"
#include "firmware/core/time.h"
#include "firmware/model/vehicle.h"

namespace m100::est {

/// Variances of a position and a velocity as poses give them at a start or a reset.
struct MotionVariance {
  double position_m2 = 0.0;
  double velocity_m2_s2 = 0.0;
};

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
  /// since the middle of that time; m/s.
  Vector3 velocity(const core::Pose<Real>& pose, core::TimePoint now, Real tilt_x_rad, Real tilt_y_rad) const {
    const Real span_s = core::seconds<Real>(since_first_ - pose.age(now));
    constexpr Real kGravity = static_cast<Real>(model::kGravity_m_s2);
    const Vector3 acceleration{kGravity * core::tan(tilt_x_rad), -kGravity * core::tan(tilt_y_rad), Real(0)};
    const Real later_s = Real(0.5) * span_s + core::seconds<Real>(pose.age(now));  // from the middle of the span to now
    return (pose.position_w_m - first_.position_w_m) / span_s + acceleration * later_s;
  }
  /// Variances of the newest position, predicted to now, and of velocity(), on one axis. With poses of variance r, the
  /// velocity (newest - first) / span has the variance 2 r / span^2, and the position, newest + age velocity, has
  /// r ((1 + age/span)^2 + (age/span)^2). Their covariance is left out; twice the variances bound what it adds.
  MotionVariance variance(const core::Pose<Real>& pose, core::TimePoint now, Eigen::Index axis) const {
    const double span_s = core::seconds<double>(span(pose, now));
    const double share = core::seconds<double>(pose.age(now)) / span_s;
    const double twice_m2 = 2.0 * static_cast<double>(pose.position_variance_m2[axis]);
    return {.position_m2 = twice_m2 * (1.0 + 2.0 * share * (1.0 + share)),
            .velocity_m2_s2 = 2.0 * twice_m2 / (span_s * span_s)};
  }
  /// Whether the row spans 0.1 s, the least for a velocity.
  bool gives_velocity(const core::Pose<Real>& pose, core::TimePoint now) const {
    return span(pose, now) >= std::chrono::milliseconds(100);
  }
  /// Whether the row may set the state: ten poses over 0.5 s (longer than Limits::gate_shut: the failsafe reacts
  /// first), after a dropout three that give a velocity.
  bool is_confirmed(const core::Pose<Real>& pose, core::TimePoint now, bool dropped_out) const {
    return dropped_out ? count_ >= 3 && gives_velocity(pose, now)
                       : count_ >= 10 && span(pose, now) >= std::chrono::milliseconds(500);
  }
  void end_row() { count_ = 0; }
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
