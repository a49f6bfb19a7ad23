// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

/// Seconds of a log on which the vehicle stood on the ground: from its start to take-off, from landing to its end. Seen
/// by every logged response (roll, pitch, climb) standing still, as far as its own noise lets it, for a second after a
/// stick that belongs to one of them went by half of its usual travel: in the air it would be answered. A log that
/// begins or ends in a hover with centred or with held sticks has none. Cost: linear in the log.
std::vector<std::pair<double, double>> ground_times(const logs::FlightLog& log);

/// Findings for ground_times(), one each.
std::vector<Finding> ground_findings(const std::vector<std::pair<double, double>>& times);

}  // namespace m100::lab::identify
