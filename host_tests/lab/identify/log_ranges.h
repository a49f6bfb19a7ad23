// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

// Ranges as they are written on the command line, on the clock of the joined logs.

/// "12:38,40:55" of a log alone; "1@12:38,2@3:40" of several, each on its own clock, counted from 1.
/// @throws InputError naming option and range: no numbers, backwards, outside of its log, no log of that number.
std::vector<Range> ranges(const std::string& option, const std::string& text, const logs::FlightLog& log);

/// "alternate:6": pieces of 6 s in turn for training and validation, of every log, or inside of the ranges `within`.
/// @throws InputError as ranges(); another word, pieces shorter than a block.
void split(const std::string& text, const std::string& within, const logs::FlightLog& log, Request& request);

/// One flight under two names is one flight: a signal that moves is the same throughout. Ranges must not share samples
/// of a flight, neither training with validation nor within one option.
/// @throws InputError.
void refuse_data_used_twice(const Request& request);

/// Adds a finding "gap" for each signal that was not sampled inside of the ranges.
void find_gaps(const logs::FlightLog& log, const std::vector<Range>& ranges, std::vector<Finding>& findings);

/// A finding that is about all the data that were used, such as a note, gets their first and last moment.
void date_findings(const Request& request, std::vector<Finding>& findings);

}  // namespace m100::lab::identify
