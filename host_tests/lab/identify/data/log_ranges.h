// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

// Converts ranges of the command line to the clock of the joined logs.

/// Parses "12:38,40:55" (FROM:TO [s]) of one log, or "1@12:38,2@3:40" of several, numbered from 1, each on its own
/// clock. @throws InputError naming option and range: none, no numbers, backwards, outside of its log, no such log.
std::vector<Range> ranges(const std::string& option, const std::string& text, const logs::FlightLog& log);

/// Parses "alternate:6": divides every log, or every range in `within`, into whole pieces of 6 s. The pieces are for
/// training and validation in turn; all are for training if the validation part has its own log.
/// @throws InputError as ranges(); for another keyword; for pieces shorter than 2.5 s.
void split(const std::string& text, const std::string& within, const logs::FlightLog& log, Request& request);

/// Checks that ranges do not share samples of a flight, neither training with validation nor within one option. One
/// flight given under two names is recognised: a measured signal that moves has equal samples. @throws InputError.
void reject_reused_data(const Request& request);

/// Adds a finding "gap" for each set of signals that are missing or spoilt in the same samples of the ranges.
void find_gaps(const logs::FlightLog& log, const std::vector<Range>& ranges, std::vector<Finding>& findings);

/// Gives each finding without a time range, such as a note, the first and last moment of the data that were used.
void date_findings(const Request& request, std::vector<Finding>& findings);

}  // namespace m100::lab::identify
