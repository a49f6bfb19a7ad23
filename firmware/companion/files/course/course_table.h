// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/files/course/course_line.h"
#include "firmware/core/maths.h"

namespace m100::companion {

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
