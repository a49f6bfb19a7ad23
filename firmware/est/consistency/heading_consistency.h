// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/frames.h"
#include "firmware/core/maths.h"
#include "firmware/est/consistency/cusum.h"
#include "firmware/est/estimate.h"
#include "firmware/est/imu_sample.h"

namespace m100::est {

/// Compares the changes of the pose's heading with those of the autopilot's.
///
/// Hypothesis: the pose turns and the aircraft does not. Statistic: |d - mean of d over 5 s|, d = yaw_pose -
/// yaw_autopilot. Subtracting the mean removes the drift of the compass.
/// Allowed: 0.21 rad. That is a time of capture that is wrong by 100 ms at the largest yaw rate, 1.75 rad/s, plus 2
/// degrees of the compass. False alarms: the noise of a pose's heading, 0.002 rad, is a hundredth of the allowed value.
/// Smallest fault detected in 3 s: a step of 0.33 rad.
///
/// No heap. Cost: three products a tick. T is float or double.
template <typename T>
class HeadingConsistency {
 public:
  /// Each tick in which the autopilot's attitude is new.
  void update(const ImuSample<T>& imu, const Estimate<T>& estimate, T step_s) {
    const T difference_rad = core::wrap_pi(estimate.yaw_rad - imu.yaw_rad);
    mean_rad_ = mean_known_ ? mean_rad_ : difference_rad;
    mean_known_ = true;
    const T turned_rad = core::wrap_pi(difference_rad - mean_rad_);
    mean_rad_ = core::wrap_pi(mean_rad_ + turned_rad * (step_s * static_cast<T>(1.0 / kMemory_s)));
    evidence_.residual = turned_rad < T(0) ? -turned_rad : turned_rad;
  }
  CheckEvidence<T>& evidence() { return evidence_; }
  T magnitude() const { return mean_rad_ < T(0) ? -mean_rad_ : mean_rad_; }
  void reset() { mean_known_ = false; }

 private:
  static constexpr double kAllowed_rad = 0.21, kMemory_s = 5.0;

  bool mean_known_ = false;
  T mean_rad_{0};
  CheckEvidence<T> evidence_{.residual = T(0), .allowed = static_cast<T>(kAllowed_rad), .cusum = {}};
};

}  // namespace m100::est
