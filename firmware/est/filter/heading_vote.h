// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"
#include "firmware/core/time.h"

namespace m100::est {

/// Three sources tell how the aircraft turns: the gyroscopes, the autopilot's heading and the pose's. Two that agree
/// outvote the third, where a wrong one would make the aircraft brake sideways.
///
/// o is the heading of the newest pose less the autopilot's; until the next pose it is carried on by the rate that
/// counts. Six numbers; no heap. Real is float or double.
template <typename Real>
class HeadingVote {
 public:
  /// Two turns agree if they differ by less: 0.1 s of a wrong time of capture at the largest yaw rate, 100 deg/s.
  static constexpr double kAgrees_rad = 0.175;

  /// With each attitude. @param yaw_rad the autopilot's heading. @param votes false: the gyroscopes count
  /// @returns the rate that counts: that of the gyroscopes, unless they have turned apart from the autopilot's heading
  ///   by kAgrees_rad within kMemory_s, and the pose has turned with that heading, to half of it; then that heading's.
  Real turn_rate(Real yaw_rad, Real gyro_rad_s, bool votes, core::TimePoint now) {
    const Real turned_rad = core::wrap_pi(yaw_rad - reported_rad_);
    const Real step_s = core::seconds<Real>(now - came_);  // not by the autopilot's clock, which may be slow
    reported_rad_ = yaw_rad;
    came_ = now;
    if (!votes || !(step_s > Real(0)) || !is_within(turned_rad, kLargestTurn_rad_s * static_cast<double>(step_s))) {
      return gyro_rad_s;
    }
    const Real kept = core::clamp(Real(1) - step_s * static_cast<Real>(1.0 / kMemory_s), Real(0), Real(1));
    gyro_apart_rad_ = kept * gyro_apart_rad_ + gyro_rad_s * step_s - turned_rad;
    const Real apart_rad = core::wrap_pi(offset_rad_ - mean_offset_rad_);
    mean_offset_rad_ += (Real(1) - kept) * apart_rad;
    if (!is_within(gyro_apart_rad_, kAgrees_rad) && is_within(apart_rad, 0.5 * kAgrees_rad)) {
      return turned_rad / step_s;
    }
    offset_rad_ += gyro_rad_s * step_s - turned_rad;  // without poses the gyroscopes count
    return gyro_rad_s;
  }
  /// With each pose. @param yaw_rad its heading
  void see_pose(Real yaw_rad) { offset_rad_ = core::wrap_pi(yaw_rad - reported_rad_); }
  /// The observer begins with the heading of the newest pose.
  void begin() { mean_offset_rad_ = offset_rad_; }
  /// The observer uses the heading of the newest pose.
  void use_pose() { used_offset_rad_ = offset_rad_; }
  /// Whether the autopilot's heading has turned as the pose's since a pose's heading was last used.
  bool confirms_pose() const { return is_within(core::wrap_pi(offset_rad_ - used_offset_rad_), kAgrees_rad); }

 private:
  /// A gyroscope's bias of 0.1 rad/s stays below kAgrees_rad.
  static constexpr double kMemory_s = 1.0;
  static constexpr double kLargestTurn_rad_s = 10.0;  ///< a heading that turns faster was reset

  /// False for NaN.
  static bool is_within(Real value, double limit) {
    return value <= static_cast<Real>(limit) && value >= static_cast<Real>(-limit);
  }

  core::TimePoint came_{};   ///< the newest attitude
  Real reported_rad_{0};     ///< by the autopilot
  Real gyro_apart_rad_{0};   ///< by how much the gyroscopes turned further than the autopilot's heading, fading
  Real offset_rad_{0};       ///< o
  Real mean_offset_rad_{0};  ///< of o, over kMemory_s
  Real used_offset_rad_{0};  ///< o when a pose's heading was last used
};

}  // namespace m100::est
