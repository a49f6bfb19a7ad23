// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <sstream>
#include <string>
#include <string_view>
#include <variant>

#include "firmware/companion/files/flight_file.h"

namespace m100::lab::experiments {

/// Numbers as TOML to the last bit, in brackets if there are several.
inline std::string number_text(std::initializer_list<double> numbers) {
  std::ostringstream out;
  out.precision(17);
  for (const double number : numbers) {
    out << (out.str().empty() ? "" : ", ") << std::showpoint << number;
  }
  return numbers.size() > 1 ? "[" + out.str() + "]" : out.str();
}

// The text of a value; empty: it is not written. One function for each type of member.
inline std::string value_text(double value, double usual) { return value == usual ? "" : number_text({value}); }
inline std::string value_text(const companion::Range& value, const companion::Range&) {
  return number_text({value.low, value.high});
}
inline std::string value_text(const link::LeverArm& value, const link::LeverArm& usual) {
  return value == usual ? "" : number_text({double{value[0]}, double{value[1]}, double{value[2]}});
}
template <typename T>
std::string value_text(const T&, const T&) {
  return "";
}

/// A flight file (TOML) for a replay, to the last bit: all ranges, and the numbers that differ from the defaults.
inline std::string to_text(const companion::FlightFile& file) {
  const companion::FlightFile defaults;
  std::ostringstream out;
  std::string_view section;
  for (const companion::FlightKey& key : companion::flight_keys()) {
    const std::string value =
        std::visit([&](auto member) { return value_text(file.*member, defaults.*member); }, key.member);
    if (value.empty()) {
      continue;
    }
    if (key.section != section) {
      out << "[" << key.section << "]\n";
      section = key.section;
    }
    out << key.key << " = " << value << "\n";
  }
  return out.str();
}

}  // namespace m100::lab::experiments
