// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::logs {

/// A proposed column map for a log with known names.
struct Proposal {
  std::string dialect;  ///< "PX4", "ArduPilot", ...
  std::string toml;     ///< text for read_column_map()
};

/// Recognises our own logs and CSV files, PX4, ArduPilot, ROS bags (DJI's topics first) and the published MAT-files by
/// the names of their columns, and maps signals whose columns (of a vector all three) are there and mostly finite.
/// nullopt: not recognised, or none of its columns is a signal. Cost: reads a few dozen columns of the log.
std::optional<Proposal> propose(const RawLog& log);

}  // namespace m100::lab::logs
