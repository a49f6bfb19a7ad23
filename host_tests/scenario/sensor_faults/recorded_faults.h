// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>

#include "host_tests/scenario/sensor_faults/fault_search.h"

namespace m100::scenario {

/// The worst fault that the search found in a channel, and how far it may move the aircraft.
struct RecordedFault {
  Fault fault;
  double limit_m = 0.0;  ///< of score_of() over the test's seeds: the measured value plus the margin stated in the file
};

/// Reads worst_faults.txt: lines `channel | limit in m | task | fault`, comment lines with `#`. @throws
/// std::invalid_argument
inline std::map<std::string, RecordedFault, std::less<>> recorded_faults(const std::filesystem::path& file) {
  std::map<std::string, RecordedFault, std::less<>> recorded;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.front() == '#') {
      continue;
    }
    const std::size_t first = line.find(" | ");
    const std::size_t second = line.find(" | ", first + 3);
    if (first == std::string::npos || second == std::string::npos) {
      throw std::invalid_argument("malformed line of kept faults: " + line);
    }
    const std::string name = line.substr(0, first);
    recorded[name] = {.fault = fault_of(channel_of(name), line.substr(second + 3)),
                      .limit_m = std::stod(line.substr(first + 3, second - first - 3))};
  }
  return recorded;
}

}  // namespace m100::scenario
