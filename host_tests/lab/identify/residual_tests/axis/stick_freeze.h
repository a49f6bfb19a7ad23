// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "firmware/model/stick_axis.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_residual.h"

namespace m100::lab::identify {

/// Detects a logged stick that freezes while the pilot moves the real one: it holds a value, which no other hold has,
/// for 0.4 s or more, then jumps by its usual step or more, and the mean squared residual in the hold and 0.6 s after
/// it is ten times that outside of all holds. Such holds must have 40 % of the residual's power and a quarter of all
/// held time; half of the time must lie outside of holds. A pilot who rests also holds values, but the vehicle then
/// follows.
/// @param model  fitted without the suspected hold (weights_beside_suspect()): a fit that includes a frozen stick
///   spreads its error over the whole log
/// @returns at most one finding.
std::vector<Finding> stick_freeze(const std::vector<const AxisDataSet*>& parts, const model::StickAxis& model);

/// Weights for a fit to the training blocks without those of the hold with the largest squared error, which could be a
/// freeze: 0 for these, 1 for the others; 1 for all if less than half would remain.
std::vector<int> weights_beside_suspect(const AxisDataSet& training, const model::StickAxis& model);

}  // namespace m100::lab::identify
