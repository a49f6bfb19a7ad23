// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/est/consistency/cusum.h"
#include "firmware/est/estimate.h"
#include "firmware/est/imu_sample.h"

namespace m100::est {

/// Compares the climb speed of the poses with the autopilot's.
///
/// Hypothesis: the pose's height moves and the aircraft does not. Statistic: |climb_pose - climb_autopilot|.
/// Allowed: 0.2 m/s (a time of capture that is wrong by 80 ms, at 2.5 m/s^2), or two sigmas of the noise that the poses
/// leave in the climb speed (0.03 m/s with those of the vehicle file), but at most 0.6 m/s (poses of 18 mm), so that a
/// faulty source cannot excuse itself; plus the observer's error in a climb.
/// Smallest fault detected in 3 s: 1.2 times the allowed value.
///
/// No heap. Cost: a comparison a tick. T is float or double.
template <typename T>
class ClimbConsistency {
 public:
  /// Each tick in which the autopilot's climb speed is new.
  void update(const ImuSample<T>& imu, const Estimate<T>& estimate, T climb_error_m_s, T noise_m2_s2) {
    const T apart_m_s = estimate.climb_m_s - imu.climb_m_s;
    evidence_.residual = apart_m_s < T(0) ? -apart_m_s : apart_m_s;
    evidence_.allowed = core::clamp(static_cast<T>(kSigmas) * core::sqrt(noise_m2_s2), static_cast<T>(kAllowed_m_s),
                                    static_cast<T>(kMaxAllowed_m_s)) +
                        climb_error_m_s;
  }
  CheckEvidence<T>& evidence() { return evidence_; }

 private:
  static constexpr double kAllowed_m_s = 0.2, kMaxAllowed_m_s = 0.6, kSigmas = 2.0;

  CheckEvidence<T> evidence_{.residual = T(0), .allowed = static_cast<T>(kAllowed_m_s), .cusum = {}};
};

}  // namespace m100::est
