// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host_tests/lab/gains/margins.h"

namespace m100::lab::gains {

/// A structure that the log allows: what the aircraft may be.
struct Structure {
  std::string name;
  model::Vehicle vehicle;
};

/// What both axes keep at worst over structures, as flown on Virtual RC.
struct Kept {
  bool stable = true;
  double peak_sensitivity = 0.0;
  double delay_margin_s = kLargestDelay_s;
};
/// @param believed what the controller believes, weights and noises included
Kept kept_over(const model::Vehicle& believed, const std::vector<Structure>& structures);

inline constexpr double kLargestMotion_deg_s = 45.0;  ///< of both tilt commands together, in hover in calm air

struct Tuned {
  model::MpcWeights weights;
  Kept kept;
  double motion_deg_s = 0.0;
  bool keeps_all = false;  ///< else: the weight with the least peak sensitivity, which does not
};

inline constexpr double kSmallestInputWeight = 0.1;
/// The weights with the smallest input weight R, and so the fastest loop, that keep as flown, on every structure, a
/// peak sensitivity of kLargestPeakSensitivity and kFieldDelayMargin_s, and move the command in hover by no more than
/// kLargestMotion_deg_s; Q stays, and so do the observer's noises. Found by bisection to 5 %. Where no R does, the one
/// of a coarse row that has the least peak sensitivity among those that hover calmly enough (or among all).
/// @param hover_motion of a hover that a controller with this belief flies [deg/s]
Tuned tune(const model::Vehicle& believed, const std::vector<Structure>& structures,
           const std::function<double(const model::Vehicle& believed)>& hover_motion);

}  // namespace m100::lab::gains
