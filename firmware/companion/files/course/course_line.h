// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/files/course/course.h"
#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/files/text/suggestion.h"
#include "firmware/core/maths.h"

// Helpers that read one line of a course; only course.cpp includes this file.
namespace m100::companion {

/// A place in the file, for error messages.
struct FilePosition {
  const std::string& name;
  int line;
  std::string word;
  [[noreturn]] void fail(const std::string& what) const {
    throw CourseError(name + ":" + std::to_string(line) + ": '" + printable(word, 60) + "': " + printable(what, 400));
  }
};

/// Why the trajectory refuses a piece, for the author of the line.
inline std::string reason(core::Status status) {
  switch (status) {
    case core::Status::kResourceExhausted:
      return "the course has more than " + std::to_string(ref::Trajectory<double>::kMaxPieces) +
             " pieces; take fewer points or turns";
    case core::Status::kInvalidArgument:
      return "times must rise by 0.05 s to an hour from point to point";
    case core::Status::kOutOfRange:
      return "a time must be above 0, a place within 1000 m, a curve 5 cm to 500 m wide, flown at 0.01 to 100 m/s in "
             "0.01 to 100 turns";
    default:
      return std::string(core::name(status));
  }
}

inline std::vector<std::string> split(const std::string& line, char separator) {
  std::vector<std::string> out;
  std::string part;
  for (std::istringstream parts(line);
       separator == ' ' ? bool(parts >> part) : bool(std::getline(parts, part, separator));) {
    const std::size_t first = part.find_first_not_of(" \t\r"), last = part.find_last_not_of(" \t\r");
    out.push_back(first == std::string::npos ? "" : part.substr(first, last - first + 1));
  }
  return out;
}

inline double number(const std::string& text, const FilePosition& spot) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, wrong] = std::from_chars(text.data() + (text.starts_with('+') ? 1 : 0), end, value);
  if (wrong != std::errc{} || stop != end || !std::isfinite(value)) {
    spot.fail("'" + text + "' is not a number");
  }
  return value;
}

/// Converts a time of at most a day; 1024 pieces of a day do not overflow a duration.
inline core::Duration seconds_of(double seconds, const FilePosition& spot) {
  constexpr double kDay_s = 86400.0;
  if (!(std::abs(seconds) <= kDay_s)) {
    spot.fail("the time is longer than a day");
  }
  return core::Duration(std::llround(seconds * 1e6));
}

inline std::vector<double> numbers(const std::vector<std::string>& words, std::size_t needed,
                                   const FilePosition& spot) {
  if (words.size() != needed + 1) {
    spot.fail("needs " + std::to_string(needed) + " numbers");
  }
  std::vector<double> out;
  for (std::size_t i = 1; i < words.size(); ++i) {
    out.push_back(number(words[i], spot));
  }
  return out;
}

/// Reads a line with limits: pairs of a name and a number. @param limits receives them: the limits that shape the
/// course. @param named receives them too; it holds only limits that a line has named.
inline void read_limits(const std::vector<std::string>& words, const FilePosition& spot, ref::SpeedLimits& limits,
                        ref::SpeedLimits& named) {
  struct Limit {
    std::string_view key;
    double ref::SpeedLimits::*member;
    double unit;
  };
  constexpr std::array kLimits{Limit{"speed_m_s", &ref::SpeedLimits::speed_m_s, 1.0},
                               Limit{"acceleration_m_s2", &ref::SpeedLimits::acceleration_m_s2, 1.0},
                               Limit{"tilt_deg", &ref::SpeedLimits::tilt_rad, core::kDegree_rad},
                               Limit{"yaw_rate_deg_s", &ref::SpeedLimits::yaw_rate_rad_s, core::kDegree_rad}};
  if (words.size() < 3 || words.size() % 2 == 0) {
    spot.fail("needs pairs of a limit and a number");
  }
  for (std::size_t i = 1; i < words.size(); i += 2) {
    const auto* const limit =
        std::find_if(kLimits.begin(), kLimits.end(), [&](const Limit& row) { return row.key == words[i]; });
    if (limit == kLimits.end()) {
      spot.fail("'" + words[i] +
                "' is not a limit; the limits are speed_m_s, acceleration_m_s2, tilt_deg, yaw_rate_deg_s" +
                did_you_mean(words[i], kLimits, &Limit::key));
    }
    const double value = number(words[i + 1], spot);
    const double max_value = limit->key == "tilt_deg" ? 60.0 : 100.0;
    if (value < 0.1 || value > max_value) {
      spot.fail(words[i] + " = " + words[i + 1] + " is outside [0.1, " + (max_value == 60.0 ? "60" : "100") + "]");
    }
    limits.*limit->member = named.*limit->member = value * limit->unit;
  }
}

/// The columns of a table of waypoints in a course, and the numbers of its rows. Errors: CourseError.
class CourseTable {
 public:
  struct Row {
    std::array<double, 3> position_m{};  ///< from the start
    double yaw_rad = 0.0;
    double at_s = 0.0;
  };

  bool is_open() const { return !columns_.empty(); }
  void begin(const std::vector<std::string>& names, const FilePosition& spot) {
    constexpr std::array<std::string_view, 6> kKnown{"t_s", "x_m", "y_m", "z_m", "yaw_rad", "yaw_deg"};
    columns_ = names;
    for (const std::string& name : names) {
      if (std::find(kKnown.begin(), kKnown.end(), name) == kKnown.end() ||
          std::count(names.begin(), names.end(), name) > 1) {
        spot.fail("'" + name +
                  "' is not a column, or appears twice; the columns are t_s, x_m, y_m, z_m, yaw_rad or yaw_deg" +
                  did_you_mean(name, kKnown));
      }
    }
    for (const std::string_view needed : {"t_s", "x_m", "y_m", "z_m"}) {
      if (std::find(names.begin(), names.end(), needed) == names.end()) {
        spot.fail("the column " + std::string(needed) + " is missing");
      }
    }
  }
  /// Precondition: is_open().
  Row row(const std::vector<std::string>& values, const FilePosition& spot) const {
    if (values.size() != columns_.size()) {
      spot.fail("the row has " + std::to_string(values.size()) + " values, the head " +
                std::to_string(columns_.size()));
    }
    constexpr std::array<std::string_view, 4> kOrder{"x_m", "y_m", "z_m", "t_s"};  // the fifth is the heading
    std::array<double, 5> n{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double value = number(values[i], spot);
      const auto at = static_cast<std::size_t>(std::find(kOrder.begin(), kOrder.end(), columns_[i]) - kOrder.begin());
      n.at(at) = columns_[i] == "yaw_deg" ? value * core::kDegree_rad : value;
    }
    return {.position_m = {n[0], n[1], n[2]}, .yaw_rad = n[4], .at_s = n[3]};
  }
  void end() { columns_.clear(); }

 private:
  std::vector<std::string> columns_;
};

}  // namespace m100::companion
