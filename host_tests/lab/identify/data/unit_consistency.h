// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

/// Finds two signals of the same quantity that contradict each other: an attitude that does not change by its rate, a
/// velocity that is not the slope of its position or the integral of its acceleration; if there is none, a climb speed
/// that decreases at more than 2 g. Checks only the signals of `axis`, in windows of one second inside `requested`
/// (empty: the log).
///
/// Both signals have errors, so the factor between them is only known to lie between the two regressions (Frisch). A
/// contradiction is reported only if this interval, widened by three standard errors, is far from 1: on a logarithmic
/// scale by more than half of the smallest factor between two common units (a knot is 0.514 m/s). Signals that share
/// less than half of their variance give no evidence.
/// @returns one wrong_unit for each contradiction. Cost: linear in the log.
std::vector<Finding> unit_contradictions(const logs::FlightLog& log, const std::string& axis,
                                         const std::vector<Range>& requested);

}  // namespace m100::lab::identify
