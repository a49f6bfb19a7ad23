// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

/// Time ranges [s] in which the vehicle stood on the ground: from the start of a flight to take-off, and from landing
/// to its end. A range is found only if a stick moves far in it while all logged responses (roll, pitch, climb) stay at
/// rest for more than a second; in the air the vehicle would answer. Cost: linear in the log.
std::vector<std::pair<double, double>> ground_times(const logs::FlightLog& log);

/// Findings for ground_times(), one each.
std::vector<Finding> ground_findings(const std::vector<std::pair<double, double>>& times);

}  // namespace m100::lab::identify
