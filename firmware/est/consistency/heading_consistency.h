// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/frames.h"
#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"
#include "firmware/est/consistency/cusum.h"
#include "firmware/est/estimate.h"
#include "firmware/est/imu_sample.h"

namespace m100::est {

/// Compares the changes of the pose's heading with those of the autopilot's, and with its gyroscopes.
///
/// Hypothesis: the pose turns and the aircraft does not. Statistic: |d - mean of d over 5 s|, d = yaw_pose -
/// yaw_autopilot, or the same with the integrated yaw rate in place of yaw_autopilot, whichever is smaller: where only
/// the autopilot's heading turns, its compass is wrong, or its estimate was reset. Subtracting the mean removes the
/// drift of compass and gyroscope.
/// Allowed: 0.21 rad. That is a time of capture that is wrong by 100 ms at the largest yaw rate, 1.75 rad/s, plus 2
/// degrees of the compass. False alarms: the noise of a pose's heading, 0.002 rad, is a hundredth of the allowed value.
/// Smallest fault detected in 3 s: a step of 0.33 rad.
///
/// No heap. Cost: seven products and a quotient a tick. T is float or double.
template <typename T>
class HeadingConsistency {
 public:
  /// Each tick in which the motion was observed.
  void update(const ImuSample<T>& imu, const Estimate<T>& estimate, T step_s) {
    yaw_rate_rad_s_ = imu.attitude_is_new ? core::yaw_rate_of<T>({.roll = imu.roll(), .pitch = imu.pitch(), .yaw = {}},
                                                                 imu.rate_b_rad_s)
                                          : yaw_rate_rad_s_;
    integrated_rad_ = core::wrap_pi(integrated_rad_ + yaw_rate_rad_s_ * step_s);
    if (!imu.attitude_is_new) {
      return;
    }
    by_heading_.update(core::wrap_pi(estimate.yaw_rad - imu.yaw_rad), step_s);
    by_gyro_.update(core::wrap_pi(estimate.yaw_rad - integrated_rad_), step_s);
    evidence_.residual = by_gyro_.turned_rad < by_heading_.turned_rad ? by_gyro_.turned_rad : by_heading_.turned_rad;
  }
  CheckEvidence<T>& evidence() { return evidence_; }
  /// By how much the autopilot's heading turned alone: the gyroscopes agree with the pose to half of what is allowed.
  /// Zero: by less than is allowed.
  T turned_alone_rad() const {
    const bool alone = by_heading_.turned_rad > evidence_.allowed && T(2) * evidence_.residual < evidence_.allowed;
    return alone ? by_heading_.turned_rad : T(0);
  }
  T magnitude() const { return by_heading_.turned_rad + by_gyro_.turned_rad; }
  void reset() {
    by_heading_ = by_gyro_ = {};
    integrated_rad_ = yaw_rate_rad_s_ = T(0);
  }

 private:
  static constexpr double kAllowed_rad = 0.21, kMemory_s = 5.0;

  /// A difference of two headings against its own mean.
  struct Turn {
    bool is_known = false;
    T mean_rad{0};
    T turned_rad{0};  ///< without its sign

    void update(T difference_rad, T step_s) {
      mean_rad = is_known ? mean_rad : difference_rad;
      is_known = true;
      const T turned = core::wrap_pi(difference_rad - mean_rad);
      mean_rad = core::wrap_pi(mean_rad + turned * (step_s * static_cast<T>(1.0 / kMemory_s)));
      turned_rad = turned < T(0) ? -turned : turned;
    }
  };

  Turn by_heading_;  ///< against the autopilot's heading
  Turn by_gyro_;     ///< against integrated_rad_
  T yaw_rate_rad_s_{0};
  T integrated_rad_{0};
  CheckEvidence<T> evidence_{.residual = T(0), .allowed = static_cast<T>(kAllowed_rad), .cusum = {}};
};

}  // namespace m100::est
