// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "firmware/model/stick_axis.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_residual.h"

namespace m100::lab::identify {

/// Detects a column of a stick that freezes while the hand moves on. Criteria: the stick holds a value for 0.4 s or
/// more that it holds only once; then it jumps further than it usually moves from one row to the next; in these holds
/// and the 0.6 s after them the residual has ten times the power per time that it has outside of them, and 40 % of all
/// power together. A hand that rests or flies steps also holds values, but then the vehicle follows the model. Where
/// holds fill half of the log, nothing can be decided.
/// @param model  fitted beside the suspect (weights_beside_suspect()): a fit to a frozen stick bends the model until
/// the
///   error is everywhere
/// @returns at most one finding.
std::vector<Finding> stick_freeze(const std::vector<const AxisDataSet*>& parts, const model::StickAxis& model);

/// Weights for a fit to the training blocks beside the hold with the largest squared error, which could be a freeze: 1
/// or 0 for each block; 1 for all where less than half of them would remain.
std::vector<int> weights_beside_suspect(const AxisDataSet& training, const model::StickAxis& model);

}  // namespace m100::lab::identify
