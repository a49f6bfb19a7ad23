// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/residual_tests/axis/axis_change_point.h"

namespace m100::lab::identify {

/// Smallest likelihood ratio of a change over all readings of a log with slow rows (intersample_hypotheses.h), with
/// weighed innovations; infinity where the rows are not slow. Below kCertainChange the unknown moment of a step of
/// the stick may have caused it: then it has no name, and there is no clean bill either, unless it is below
/// kChanceChange.
double min_ratio_over_hypotheses(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                 const Fit& fit, const ChangePoint& change);

/// Searches both sides of a change for another change. A permanent change leaves both sides steady; a temporary one
/// (another mode of the autopilot for a while) is two changes, and one of them alone could get many names.
/// @returns the change that one side shows by itself with at least half the likelihood ratio, if there is one.
std::optional<Change> second_change_point(const AxisData& data, const std::vector<Range>& ranges,
                                          const AxisFamily& family, const Fit& fit, const ChangePoint& change);

}  // namespace m100::lab::identify
