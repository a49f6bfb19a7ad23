// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sstream>
#include <string>
#include <string_view>

#include "firmware/companion/files/flight_file.h"

namespace m100::lab::experiments {

/// A flight file (TOML) for a replay, to the last bit: all ranges, and the numbers that differ from the defaults.
inline std::string to_text(const companion::FlightFile& file) {
  const companion::FlightFile defaults;
  std::ostringstream out;
  out.precision(17);
  std::string_view section;
  for (const companion::FlightKey& key : companion::flight_keys()) {
    const bool is_number = key.number != nullptr && file.*key.number != defaults.*key.number;
    const bool is_vector = key.vector != nullptr && file.*key.vector != defaults.*key.vector;
    if (!is_number && !is_vector && key.range == nullptr) {
      continue;
    }
    if (key.section != section) {
      out << "[" << key.section << "]\n";
      section = key.section;
    }
    out << key.key << " = ";
    if (is_number) {
      out << std::showpoint << file.*key.number << "\n";
    } else if (is_vector) {
      const auto& [forward_m, left_m, up_m] = file.*key.vector;
      out << std::showpoint << "[" << forward_m << ", " << left_m << ", " << up_m << "]\n";
    } else {
      out << "[" << std::showpoint << (file.*key.range).low << ", " << (file.*key.range).high << "]\n";
    }
  }
  return out.str();
}

}  // namespace m100::lab::experiments
