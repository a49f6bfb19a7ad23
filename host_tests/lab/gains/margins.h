// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <functional>

#include "host_tests/lab/gains/axis_model.h"

namespace m100::lab::gains {

/// What the sampled loop of one axis stands, opened at the attitude command. margins_of(): with a command in every tick
/// of 10 ms, as the paper has it; flown_margins_of(): as the program flies. The axis as the vehicle file states it,
/// steady observer (position, tilt, tilt rate measured; disturbance and input offset estimated), prediction through the
/// delay, unconstrained MPC and a pose whose age the observer knows (est/delayed_pose.h) included. Limits are not.
struct Margins {
  bool stable = false;
  double peak_sensitivity = 0.0;
  double gain_margin = 0.0;  ///< smallest factor above 1 that makes the loop oscillate
  double phase_margin_rad = 0.0;
  double delay_margin_s = 0.0;   ///< smallest delay that makes it oscillate
  double crossover_rad_s = 0.0;  ///< largest frequency at which the loop gain is 1
};

/// What lies between the law and the aircraft and back.
struct Way {
  std::size_t command_ticks = 4;       ///< of 10 ms, from one command to the next, which holds: 25 Hz
  std::size_t attitude_age_ticks = 1;  ///< what app/config.h says, and what was measured on the simulated autopilot
  std::size_t pose_age_ticks = 2;
  bool by_sticks = true;       ///< the scale of the vehicle's stick counts; else it is told angles
  double extra_delay_s = 0.0;  ///< of the command, beyond the vehicle's own, that nobody was told
};
inline constexpr Way kVirtualRcWay{};
inline constexpr Way kMovementWay{.command_ticks = 2, .by_sticks = false};
inline constexpr int kFrequencies = 3000;       ///< of a frequency response, from 0.02 rad/s on
inline constexpr double kLargestDelay_s = 0.4;  ///< of a margin: more is not looked for

/// Margins of the controller of `believed`, as it flies: commands that hold between two of them, observer and
/// prediction as the flight code computes them (linear about hover), measurements of their age, on an axis that really
/// is `truth`, whose transport delay counts all that lies between the tick and the attitude loop, and whose stick has
/// the scale that the vehicle file states; the dead zone is taken as inverted exactly. The delay margin
/// comes from the eigenvalues of the closed loop, in steps of 0.2 ms, up to kLargestDelay_s.
Margins flown_margins_of(const model::Vehicle& believed, const model::Vehicle& truth, Axis axis, const Way& way,
                         int frequencies = kFrequencies);

/// Margins from a frequency response, from the vehicle's command to the controller's, sampled so often; `stable` is
/// left to the caller.
Margins margins_from(const std::function<std::complex<double>(double frequency_rad_s)>& response, double period_s,
                     int frequencies = kFrequencies);

inline constexpr double kLargestPeakSensitivity = 1.6;
inline constexpr double kSmallestDelayMargin_s = 0.1;
inline constexpr double kFieldDelayMargin_s = 0.06;  ///< in every corner of every structure, as flown

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

}  // namespace m100::lab::gains
