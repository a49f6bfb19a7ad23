// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

namespace m100::host_tests {

/// How often the interval of one parameter contained the true value.
struct Coverage {
  int asked = 0;                ///< logs that have the parameter
  int answered = 0;             ///< of these, logs answered with the true structure
  int covered = 0;              ///< of these, logs whose 95 % interval contains the true value
  double relative_width = 0.0;  ///< sum of half width over true value
  double relative_error = 0.0;  ///< sum of error over true value
};

/// Least and largest share of the 95 % intervals of a parameter that contain the true value.
inline constexpr double kMin = 0.92;
inline constexpr double kMax = 0.98;         ///< above this, intervals are too wide
inline constexpr double kMinAnswered = 0.9;  ///< least share of answered logs; fewer may be a favourable selection

/// Two standard errors of a share that was counted in this number of logs.
inline double two_standard_errors(double share, int logs) { return 2.0 * std::sqrt(share * (1.0 - share) / logs); }

inline std::string sentence(const std::string& name, const char* what, double share, double limit) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%s: %s in %.1f %%, the limit is %.1f %%", name.c_str(), what, 100.0 * share,
                100.0 * limit);
  return text.data();
}

/// @returns a sentence for each share outside of these limits by more than two standard errors.
/// @param counts by "axis parameter"
inline std::vector<std::string> outside_limits(const std::map<std::string, Coverage>& counts) {
  std::vector<std::string> out;
  for (const auto& [name, count] : counts) {
    const double answered = count.asked > 0 ? static_cast<double>(count.answered) / count.asked : 0.0;
    if (answered < kMinAnswered) {
      out.push_back(sentence(name, "too few logs answered with the true structure:", answered, kMinAnswered));
    }
    if (count.answered == 0) {
      continue;
    }
    const double covered = static_cast<double>(count.covered) / count.answered;
    if (covered < kMin - two_standard_errors(kMin, count.answered)) {
      out.push_back(sentence(name, "the truth", covered, kMin - two_standard_errors(kMin, count.answered)));
    }
    if (covered > kMax + two_standard_errors(kMax, count.answered)) {
      out.push_back(sentence(name, "too wide: the truth", covered, kMax + two_standard_errors(kMax, count.answered)));
    }
  }
  if (counts.empty()) {
    out.emplace_back("no log was analysed");
  }
  return out;
}

}  // namespace m100::host_tests
