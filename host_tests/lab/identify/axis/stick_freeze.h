// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "firmware/model/stick_axis.h"
#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/axis/axis_remainder.h"

namespace m100::lab::identify {

/// A column that stops while the hand goes on: the stick holds one value that it holds only once, for 0.4 s or more,
/// then jumps as it hardly ever does from one row to the next, and in such holds and the 0.6 s after them the model
/// leaves ten times the power per time that it leaves outside of all of them, 40 % of all power together. A hand that
/// rests, or that flies steps, holds as well, but its vehicle does what the model says. Where the holds fill half of
/// the log nobody can tell.
/// @returns at most one finding.
std::vector<Finding> stick_freeze(const std::vector<const AxisPart*>& parts, const model::StickAxis& model);

}  // namespace m100::lab::identify
