// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#ifdef M100_TRANSITIONS_CAN_BE_DISABLED
#include <type_traits>
#endif

namespace m100::safety {

#ifdef M100_TRANSITIONS_CAN_BE_DISABLED
/// For a test of the tests, in a separate build (host_tests/unit/safety/transitions_main.cpp): the row that run-time
/// lookups skip. Flight builds are compiled without it.
template <typename Row>
inline std::size_t disabled_transition = SIZE_MAX;

template <typename Row>
constexpr bool is_on(std::size_t number) {
  return std::is_constant_evaluated() || number != disabled_transition<Row>;
}
#else
template <typename Row>
constexpr bool is_on(std::size_t) {
  return true;
}
#endif

/// Reads a table from the top; the first row that matches wins. (The authority table has match_number() for this.)
/// @returns the number of the row; the table's size if none matches.
template <typename Row, std::size_t kRows, typename Matches>
constexpr std::size_t first_row(const std::array<Row, kRows>& table, const Matches& matches) {
  std::size_t number = 0;
  while (number < kRows && !(matches(table[number]) && is_on<Row>(number))) {
    ++number;
  }
  return number;
}

}  // namespace m100::safety
