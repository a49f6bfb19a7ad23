// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host_tests/lab/gains/margins.h"

namespace m100::lab::gains {

/// A model structure that agrees with the log, so that the aircraft may have it.
struct Structure {
  std::string name;
  model::Vehicle vehicle;
};

/// The worst margins of both axes over several structures, as flown on Virtual RC.
struct TunedMargins {
  bool stable = true;
  double peak_sensitivity = 0.0;
  double delay_margin_s = kLargestDelay_s;
};
/// @param believed vehicle file of the controller, including weights and noises
TunedMargins margins_over(const model::Vehicle& believed, const std::vector<Structure>& structures);

inline constexpr double kLargestMotion_deg_s = 45.0;  ///< motion of both tilt commands together, in hover in calm air

struct Tuned {
  model::MpcWeights weights;
  TunedMargins kept;
  double motion_deg_s = 0.0;
  bool keeps_all = false;  ///< false: no weight keeps all limits, and tune() chose the least peak sensitivity
};

inline constexpr double kSmallestInputWeight = 0.1;
/// Finds the smallest input weight R, and so the fastest loop, that keeps kLargestPeakSensitivity and
/// kFieldDelayMargin_s as flown on every structure, and a hover_motion() of at most kLargestMotion_deg_s. Q and the
/// observer's noises stay. The search is a bisection to 5 %. If no R keeps the limits, it returns the R of a coarse
/// series with the least peak sensitivity, if possible one that is stable and keeps the limit of the motion.
/// @param hover_motion returns the command motion [deg/s] of a hover with this vehicle file
Tuned tune(const model::Vehicle& believed, const std::vector<Structure>& structures,
           const std::function<double(const model::Vehicle& believed)>& hover_motion);

}  // namespace m100::lab::gains
