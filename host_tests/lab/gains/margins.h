// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <functional>
#include <string>

#include "host_tests/lab/gains/axis_model.h"

namespace m100::lab::gains {

/// Stability margins of a sampled loop that is opened at the command of one axis.
struct Margins {
  bool stable = false;
  double peak_sensitivity = 0.0;
  double gain_margin = 0.0;  ///< smallest factor above 1 that makes the loop oscillate
  double phase_margin_rad = 0.0;
  double delay_margin_s = 0.0;   ///< smallest delay that makes the loop oscillate
  double crossover_rad_s = 0.0;  ///< largest frequency at which the loop gain is 1
};

/// Timing and scaling between the law and the aircraft, in both directions.
struct LoopTiming {
  std::size_t command_ticks = 4;       ///< ticks of 10 ms for which a command holds: 25 Hz
  std::size_t attitude_age_ticks = 1;  ///< age of attitude and rate, as in app/config.h
  std::size_t pose_age_ticks = 2;
  bool by_sticks = true;       ///< commands have the scale of the vehicle's stick counts; false: they are angles
  double extra_delay_s = 0.0;  ///< unknown delay of the command, in addition to the vehicle's own
};
/// "virtual_rc at 25 Hz, pose 20 ms old"
std::string words(const LoopTiming& timing);
inline constexpr LoopTiming kVirtualRcTiming{};
inline constexpr LoopTiming kMovementTiming{.command_ticks = 2, .by_sticks = false};
inline constexpr int kFrequencies = 3000;       ///< points of a frequency response, starting at 0.02 rad/s
inline constexpr double kLargestDelay_s = 0.4;  ///< largest delay margin that is searched

/// Margins, as flown, of the controller of `believed` on an axis that really is `truth`. Observer and prediction are
/// those of the flight code, linear about hover. The transport delay of `truth` includes everything between the tick
/// and the attitude loop. The stick's dead zone is assumed to be inverted exactly. The delay margin is found to 0.2 ms,
/// up to kLargestDelay_s.
Margins flown_margins_of(const model::Vehicle& believed, const model::Vehicle& truth, Axis axis,
                         const LoopTiming& timing, int frequencies = kFrequencies);

/// Margins from the frequency response -L from the vehicle's command to the controller's. `stable` is by the Nyquist
/// criterion: the poles of the open loop must be stable, except one or two at 0.
Margins margins_from(const std::function<std::complex<double>(double frequency_rad_s)>& response, double period_s,
                     int frequencies = kFrequencies);

inline constexpr double kLargestPeakSensitivity = 1.6;
inline constexpr double kSmallestDelayMargin_s = 0.1;
inline constexpr double kFieldDelayMargin_s = 0.06;  ///< required as flown by tune() and loop::MarginOrder

inline bool is_robust(const Margins& margins) {
  return margins.stable && margins.peak_sensitivity <= kLargestPeakSensitivity &&
         margins.delay_margin_s >= kSmallestDelayMargin_s;
}

}  // namespace m100::lab::gains
