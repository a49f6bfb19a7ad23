// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

#include <cstdlib>
#include <sstream>
#include <string>

namespace m100::lab {

// Checks for what CLI11's own checks accept: NaN is inside every CLI::Range, and a negative number wraps into an
// unsigned one.

/// A finite number from `low` to `high`, both included.
inline CLI::Validator from_to(double low, double high) {
  std::ostringstream range;
  range << "from " << low << " to " << high;
  return CLI::Validator(
      [low, high, words = range.str()](std::string& text) {
        char* end = nullptr;
        const double value = std::strtod(text.c_str(), &end);
        const bool is_inside = !text.empty() && *end == '\0' && value >= low && value <= high;
        return is_inside ? std::string() : "'" + text + "' is not a number " + words;
      },
      range.str());
}

/// A text of one or more digits and nothing else.
inline CLI::Validator whole_number() {
  return CLI::Validator(
      [](std::string& text) {
        const bool is_whole = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
        return is_whole ? std::string() : "'" + text + "' is not a whole number (0 or more)";
      },
      "a whole number");
}

}  // namespace m100::lab
