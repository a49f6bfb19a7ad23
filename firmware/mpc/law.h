// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace m100::mpc {

/// Law that solves the horizontal program. Both laws have the same table, predictor, targets and limits.
enum class Law : std::uint8_t {
  kMpc,  ///< the optimum of the program with its limits
  kLqr,  ///< the baseline: the optimum without limits, clipped to them (Path::kClipped where a limit binds)
};

struct LawName {
  Law law;
  std::string_view word;  ///< in options, logs and reports
};
inline constexpr std::array kLawNames{LawName{Law::kMpc, "mpc"}, LawName{Law::kLqr, "lqr"}};

constexpr std::string_view name(Law law) {
  for (const LawName& row : kLawNames) {
    if (row.law == law) {
      return row.word;
    }
  }
  return "";
}
constexpr std::optional<Law> law_of(std::string_view word) {
  for (const LawName& row : kLawNames) {
    if (row.word == word) {
      return row.law;
    }
  }
  return std::nullopt;
}

}  // namespace m100::mpc
