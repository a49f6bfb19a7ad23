// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/aliases.h"
#include "firmware/companion/files/text/json.h"

#include <gtest/gtest.h>

namespace m100::lab {
namespace {

// Catches a reader that loses what an older version wrote under another name.
TEST(Aliases, FilesOfOlderVersionsAreReadUnderTodaysNames) {
  for (const Alias& alias : kAliases) {
    Json inner{{std::string(alias.before), 7}, {std::string(alias.before) + ".roll", 8}};
    const Json read = with_current_names(Json{{"flights", Json::array({inner})}});
    const Json& flight = read.at("flights").at(0);
    EXPECT_EQ(flight.at(std::string(alias.now)), 7) << alias.before;
    EXPECT_EQ(flight.at(std::string(alias.now) + ".roll"), 8) << alias.before;
    EXPECT_EQ(flight.size(), 2U) << "the old name must be gone";
  }
}

// Catches a table that renames names which are current, or text that only contains an old name.
TEST(Aliases, OtherNamesAndValuesStay) {
  const Json current{{"rooms", "ladder"}, {"failsafe", {{"cause", "room"}}}};
  EXPECT_EQ(with_current_names(current), current);
  for (const Alias& alias : kAliases) {
    EXPECT_EQ(alias_of(alias.now), alias.now);
  }
}

}  // namespace
}  // namespace m100::lab
