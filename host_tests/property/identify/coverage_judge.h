// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace m100::host_tests {

/// How often the interval of one parameter held the truth.
struct Coverage {
  int asked = 0;                ///< logs in which it is there to be found
  int answered = 0;             ///< of them with the structure that is there
  int covered = 0;              ///< of them with the truth inside of the 95 % interval
  double relative_width = 0.0;  ///< summed half width over the truth
  double relative_error = 0.0;  ///< summed error over the truth
};

/// What share of the 95 % intervals of an axis or of one parameter holds the truth, as the README of identify states
/// it; asked for are 92 to 98 %.
struct Reached {
  std::string_view name;  ///< of an axis, or "axis parameter"
  double share;
};
inline constexpr std::array kReached{Reached{"roll", 0.92}, Reached{"translation", 0.92},
                                     Reached{"translation x_per_s", 0.89}};
inline constexpr double kMost = 0.98;     ///< above, intervals are too wide
inline constexpr double kAnswered = 0.9;  ///< of the logs asked: fewer, and the rest may be the lucky ones

/// What chance does to a share that was counted in so many logs: two standard errors.
inline double chance(double share, int logs) { return 2.0 * std::sqrt(share * (1.0 - share) / logs); }

inline std::string sentence(const std::string& name, const char* what, double share, double limit) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%s: %s in %.1f %%, the limit is %.1f %%", name.c_str(), what, 100.0 * share,
                100.0 * limit);
  return text.data();
}

/// The share of intervals that kReached states for this parameter, or else for its axis; 1 where it states none.
inline double reached_by(const std::string& name) {
  double share = 1.0;
  for (const Reached& one : kReached) {
    if (name == one.name) {
      return one.share;
    }
    if (name.starts_with(std::string(one.name) + " ")) {
      share = one.share;
    }
  }
  return share;
}

/// Sentences about what is not as stated; none: all is.
/// @param counts by "axis parameter"
inline std::vector<std::string> not_as_stated(const std::map<std::string, Coverage>& counts) {
  std::vector<std::string> out;
  for (const auto& [name, count] : counts) {
    const double answered = count.asked > 0 ? static_cast<double>(count.answered) / count.asked : 0.0;
    if (answered < kAnswered) {
      out.push_back(sentence(name, "too few answers: the structure that is there", answered, kAnswered));
    }
    if (count.answered == 0) {
      continue;
    }
    const double covered = static_cast<double>(count.covered) / count.answered;
    const double reached = reached_by(name);
    if (covered < reached - chance(reached, count.answered)) {
      out.push_back(sentence(name, "the truth", covered, reached - chance(reached, count.answered)));
    }
    if (covered > kMost + chance(kMost, count.answered)) {
      out.push_back(sentence(name, "too wide: the truth", covered, kMost + chance(kMost, count.answered)));
    }
  }
  if (counts.empty()) {
    out.emplace_back("nothing was asked");
  }
  return out;
}

}  // namespace m100::host_tests
