// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "host_tests/lab/identify/axis/axis_change.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// Likelihood ratio of a change under that reading of a log with slow rows (row_readings.h) that speaks least for it,
/// the innovations weighed by what is known of them; infinity where the rows are not slow. Below kChangeIsCertain the
/// row that fell between two steps of the stick may have made it: it has no name, and no clean bill is due either,
/// unless it is below what chance reaches.
double ratio_between_rows(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                          const Fit& fit, const AxisChange& change);

/// A vehicle that became another one and stayed it is steady on both sides of the date. What comes and goes, a mode of
/// the autopilot for a while, is two changes, of which each alone has any name that fits.
/// @returns the change that one of the sides shows by itself, at least half as likely, if there is one.
std::optional<Change> another_change(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                     const Fit& fit, const AxisChange& change);

}  // namespace m100::lab::identify
