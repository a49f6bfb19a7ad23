// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "host_tests/lab/identify/axis/axis_change.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// Whether a change is as certain under every reading of a log with slow rows (row_readings.h), the innovations weighed
/// by what is known of them. Where it is not, the row that fell between two steps of the stick may have made it: it has
/// no name, and it is no clean bill either.
bool stands_between_rows(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                         const Fit& fit, const AxisChange& change);

/// A vehicle that became another one and stayed it is steady on both sides of the date. What comes and goes, a mode of
/// the autopilot for a while, is two changes, of which each alone has any name that fits.
/// @returns the change that one of the sides shows by itself, at least half as likely, if there is one.
std::optional<Change> another_change(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                     const Fit& fit, const AxisChange& change);

}  // namespace m100::lab::identify
