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

/// Every fault at every stage, on both channels, plain; encrypted in flight and while asking; pairs drawn by a seed;
/// and a part of it again in real time.
std::vector<Case> whole_battery();
/// What is run at every change: each fault once in flight, with the channel and a second stage taken in turn.
std::vector<Case> short_battery();

/// For a program that counts what its flying thread allocates: whatever makes it say or do something of its own, on
/// both channels, with log and result.
std::vector<Case> counted_battery();

/// Flies the cases, so many at a time. @param folder for their files; those of a case that failed are kept.
std::vector<Result> fly_all(const std::vector<Case>& cases, const Places& places, std::size_t jobs,
                            const std::vector<std::string>& open, std::ostream& out);

/// Fault x stage: the slowest return of control, and the last control byte after a loss. Markdown.
std::string matrix(const std::vector<Result>& results);
std::string to_json(const std::vector<Result>& results);

}  // namespace m100::sticks
