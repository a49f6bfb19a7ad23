// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "host_tests/scenario/authority/flight_case.h"

namespace m100::authority {

struct Result {
  Case flown;
  Verdict verdict;
  bool open = false;  ///< known to fail still
  bool passed() const { return verdict.counted && verdict.violations.empty(); }
};

/// Every fault at every stage, on both channels, plain and encrypted; pairs drawn from a seed; and some of the cases
/// again in real time.
std::vector<Case> whole_battery();
/// The cases run at every change: each fault once in flight, with the channel and a second stage in turn.
std::vector<Case> short_battery();

/// For the program that counts the allocations of its flying thread: every fault that makes it print or do something,
/// on both channels, with log and result.
std::vector<Case> counted_battery();

/// The operator's stop on a line that loses 5, 10 and 20 % in both directions, over seeds and both channels.
std::vector<Case> losses_battery();
/// Distribution of the times as a Markdown table, one row per share and channel.
std::string losses_table(const std::vector<Result>& results);
/// Whether the required shares of flights gave control back within the second of R15.
bool losses_hold(const std::vector<Result>& results);

/// Flies the cases, `jobs` at a time. The files of a case that failed are kept.
std::vector<Result> fly_all(const std::vector<Case>& cases, const Places& places, std::size_t jobs,
                            const std::vector<std::string>& open, std::ostream& out);

/// Markdown table of faults and stages: the slowest return of control, and the last control byte after a loss.
std::string matrix(const std::vector<Result>& results);
std::string to_json(const std::vector<Result>& results);

}  // namespace m100::authority
