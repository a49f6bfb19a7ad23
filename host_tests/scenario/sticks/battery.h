// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "host_tests/scenario/sticks/flight_case.h"

namespace m100::sticks {

struct Result {
  Case flown;
  Verdict verdict;
  bool open = false;  ///< known not to hold yet
  bool passed() const { return verdict.counted && verdict.violations.empty(); }
};

/// Every fault at every stage, on both channels, plain and encrypted; pairs drawn by a seed; and a part of it again in
/// real time.
std::vector<Case> whole_battery();
/// What is run at every change: each fault once in flight, with the channel and a second stage taken in turn.
std::vector<Case> short_battery();

/// For a program that counts what its flying thread allocates: whatever makes it say or do something of its own, on
/// both channels, with log and result.
std::vector<Case> counted_battery();

/// The operator's stop on a line that loses 5, 10 and 20 % of what is written both ways, over seeds and both channels.
std::vector<Case> losses_battery();
/// Its distribution. Markdown, one line a share and channel.
std::string losses_table(const std::vector<Result>& results);
/// The shares of flights that must have control back within the second of R15 hold.
bool losses_hold(const std::vector<Result>& results);

/// Flies the cases, so many at a time. @param folder for their files; those of a case that failed are kept.
std::vector<Result> fly_all(const std::vector<Case>& cases, const Places& places, std::size_t jobs,
                            const std::vector<std::string>& open, std::ostream& out);

/// Fault x stage: the slowest return of control, and the last control byte after a loss. Markdown.
std::string matrix(const std::vector<Result>& results);
std::string to_json(const std::vector<Result>& results);

}  // namespace m100::sticks
