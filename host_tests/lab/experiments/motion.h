// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "host_tests/lab/experiments/results.h"

namespace m100::lab::experiments {

/// Command motion and pose error with one input weight.
struct MotionPoint {
  double input_weight = 0.0;
  std::optional<Cell> hover;   ///< in calm air; empty: control was never obtained
  std::optional<Cell> square;  ///< the trajectory in calm air; empty: control was never obtained
  int refused = 0;             ///< flights of both tasks that never obtained control
};

/// Flies hover and trajectory in calm air with the vehicle file's input weight times 1/8 to 4.
std::vector<MotionPoint> fly_motion(const SuiteOptions& options);

void print_motion(std::ostream& out, const std::vector<MotionPoint>& points);
/// [{"input_weight": 0, "hover": {"pose_m": 0, "command_deg_s": 0}, "square": {...}}]; null: not flown.
nlohmann::json motion_to_json(const std::vector<MotionPoint>& points);
/// Writes a self-contained page with the curve, motion.html, and the curve alone, motion.svg. Errors: InputError.
void write_motion_report(const std::string& folder, const std::vector<MotionPoint>& points, const std::string& about);

}  // namespace m100::lab::experiments
