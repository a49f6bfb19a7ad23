// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/tools/gains/axis_model.h"

namespace m100::tools::gains {

/// What the sampled loop of one axis stands, opened at the attitude command, 100 Hz; the axis as the vehicle file
/// states it, steady observer (position, tilt, tilt rate measured; disturbance and input offset estimated), prediction
/// through the delay, unconstrained MPC and a pose whose age the observer knows (est/delayed_pose.h) included. Limits
/// are not.
struct Margins {
  bool stable = false;
  double peak_sensitivity = 0.0;
  double gain_margin = 0.0;  ///< smallest factor above 1 that makes the loop oscillate
  double phase_margin_rad = 0.0;
  double delay_margin_s = 0.0;   ///< smallest delay that makes it oscillate
  double crossover_rad_s = 0.0;  ///< largest frequency at which the loop gain is 1
};

inline constexpr double kLargestPeakSensitivity = 1.6;
inline constexpr double kSmallestDelayMargin_s = 0.1;

/// Margins of the controller that `believed` gives, on an axis that really is `truth` (the same axis of two vehicles).
/// @param pose_age_ticks age of every pose, in ticks of 10 ms; the paper's wireless link and motion capture: 1 to 8.
Margins margins_of(const model::Vehicle& believed, const model::Vehicle& truth, Axis axis,
                   std::size_t pose_age_ticks = 0);
inline Margins margins_of(const model::Vehicle& vehicle, Axis axis, std::size_t pose_age_ticks = 0) {
  return margins_of(vehicle, vehicle, axis, pose_age_ticks);
}
inline bool is_robust(const Margins& margins) {
  return margins.stable && margins.peak_sensitivity <= kLargestPeakSensitivity &&
         margins.delay_margin_s >= kSmallestDelayMargin_s;
}

inline constexpr double kSmallestInputWeight = 0.1;
inline constexpr double kLargestInputWeight = 1000.0;
/// The weights with the smallest input weight R, and so the fastest loop, that keep both axes robust; Q stays. Found by
/// bisection to 2 %. Throws std::domain_error when even kLargestInputWeight does not.
model::MpcWeights tuned_weights(const model::Vehicle& vehicle);

}  // namespace m100::tools::gains
