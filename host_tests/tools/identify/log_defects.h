// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host_tests/tools/logs/flight_log.h"

namespace m100::tools::identify {

// What is wrong with a log, as far as the log itself shows it. Nothing here knows a model.

/// Seconds of a log on which the vehicle stood on the ground: from its start to take-off, from landing to its end. Seen
/// by every logged response (roll, pitch, climb) standing still while a stick that belongs to one of them is held
/// beyond half of its usual travel: in the air it would be answered. A log that begins or ends in a hover with centred
/// sticks has none. Cost: linear in the log.
std::vector<std::pair<double, double>> ground_times(const logs::FlightLog& log);

/// Sentences for ground_times(), one each.
std::vector<std::string> ground_findings(const std::vector<std::pair<double, double>>& times);

/// 0 where `valid` is to be left out: on the ground and the first second after, and `memory_s` after every gap, in
/// which the past input is not known.
void mask_unusable(const logs::FlightLog& log, const std::vector<std::pair<double, double>>& ground, double memory_s,
                   std::vector<char>& valid);

/// How long a moving signal holds one value: the median length of its runs of equal samples. One sample period or less:
/// not held.
double hold_s(const std::vector<double>& values, const std::vector<char>& used, double period_s);

/// Share of the used samples on which a stick stands at one and the same largest value, on both sides alike: a log that
/// was cut there, or a pilot who flies stops only.
double cut_share(const std::vector<double>& stick, const std::vector<char>& used);

/// @throws InputError: roll or pitch beyond half a turn, which no attitude is: degrees, taken for radians.
void check_units(const logs::FlightLog& log);

}  // namespace m100::tools::identify
