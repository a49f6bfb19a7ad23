// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::logs {

/// A column map for a log whose names are known here.
struct Proposal {
  std::string dialect;  ///< "PX4", "ArduPilot", ...
  std::string toml;     ///< what read_column_map() reads
};

/// Recognises our own logs and CSV files, PX4, ArduPilot, ROS bags (DJI's topics first) and the published MAT-files by
/// the names of their columns, and maps what is there and mostly sound. nullopt: nothing that is known. Cost: a few
/// dozen columns of the log.
std::optional<Proposal> propose(const RawLog& log);

}  // namespace m100::lab::logs
