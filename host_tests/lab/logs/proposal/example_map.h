// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host_tests/lab/logs/raw_log.h"
#include "host_tests/lab/logs/signal.h"

namespace m100::lab::logs {

/// The signal that a column's name states by the words of the field: "cmd_roll", "rollRate", "vx". nullopt: none, or
/// more than one. @param unknown  receives the number of words that state nothing.
std::optional<Signal> signal_named(const std::string& column, std::size_t& unknown);

/// An example of a column map for a log with names that no dialect has: the log's clock, and each signal that a
/// column's name states. Units follow from the values; "..." stands for a column that must be filled in.
std::string example_map(const RawLog& log);

/// The log's first columns, as many as are searched for numbers: the search of a wide file must end.
std::vector<std::string> first_names(const RawLog& log);

/// The values of a column; none if it cannot be read as numbers.
std::vector<double> numbers_of(const RawLog& log, const std::string& name);

}  // namespace m100::lab::logs
