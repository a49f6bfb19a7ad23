// SPDX-License-Identifier: BSD-3-Clause
// Runs the tests of the safety tables with one row switched off if asked to: `--without=failsafe:3`,
// `--without=authority:17`. `--rows` lists the rows that can be switched off. Used by every_transition_is_missed.sh.
#include <gtest/gtest.h>

#include <charconv>
#include <iostream>
#include <string_view>

#include "firmware/safety/authority_table.h"
#include "firmware/safety/failsafe.h"

namespace {

using namespace m100::safety;

void list_rows() {
  for (std::size_t i = 0; i < kFailsafeTransitions.size(); ++i) {
    std::cout << "failsafe:" << i << " " << name(kFailsafeTransitions[i].from) << " -> "
              << name(kFailsafeTransitions[i].to) << ", " << name(kFailsafeTransitions[i].why) << "\n";
  }
  for (std::size_t i = 0; i < kAuthorityTable.size(); ++i) {
    std::cout << "authority:" << i << " -> " << name(kAuthorityTable[i].to) << ", " << name(kAuthorityTable[i].reason)
              << "\n";
  }
}

/// @returns false if the row does not exist.
bool switch_off(std::string_view row) {
  const std::size_t colon = row.find(':');
  const std::string_view table = row.substr(0, colon);
  const std::string_view digits = colon == std::string_view::npos ? std::string_view{} : row.substr(colon + 1);
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc{} || end != digits.data() + digits.size()) {
    return false;
  }
  if (table == "failsafe" && number < kFailsafeTransitions.size()) {
    disabled_transition<FailsafeTransition> = number;
    return true;
  }
  if (table == "authority" && number < kAuthorityTable.size()) {
    disabled_transition<AuthorityTransition> = number;
    return true;
  }
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  constexpr std::string_view kWithout = "--without=";
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == "--rows") {
      list_rows();
      return 0;
    }
    if (!word.starts_with(kWithout) || !switch_off(word.substr(kWithout.size()))) {
      std::cerr << "There is no row or option " << word << "; --rows lists the rows.\n";
      return 2;
    }
  }
  return RUN_ALL_TESTS();
}
