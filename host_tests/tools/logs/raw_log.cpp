// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/logs/raw_log.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <numeric>

#include "host_tests/tools/input_error.h"

namespace m100::tools::logs {
namespace {

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, change});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string nearest_names(const std::vector<std::string>& names, const std::string& wanted, std::size_t count) {
  std::vector<std::string> sorted = names;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const auto& a, const auto& b) { return edit_distance(a, wanted) < edit_distance(b, wanted); });
  std::string text;
  for (std::size_t i = 0; i < std::min(count, sorted.size()); ++i) {
    text += (i == 0 ? "" : ", ") + sorted[i];
  }
  return text + (sorted.size() > count ? ", ..." : "");
}

std::unique_ptr<RawLog> open_log(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    throw InputError(file, 0, "", "cannot be opened");
  }
  std::array<char, 8> start{};
  in.read(start.data(), start.size());
  const std::string head(start.data(), static_cast<std::size_t>(in.gcount()));
  if (head.empty()) {
    throw InputError(file, 0, "", "is empty");
  }
  if (head.rfind("ULog", 0) == 0) {
    return open_ulog(file);
  }
  if (head.rfind("MATLAB", 0) == 0) {
    return open_mat(file);
  }
  if (head.rfind("#ROSBAG", 0) == 0) {
    if (head != "#ROSBAG ") {
      throw InputError(file, 0, "", "not a ROS bag of format 2.0");
    }
    return open_rosbag(file);
  }
  return open_csv(file);
}

}  // namespace m100::tools::logs
