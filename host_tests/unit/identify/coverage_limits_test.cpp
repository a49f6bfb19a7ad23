// SPDX-License-Identifier: BSD-3-Clause
// Proves that the judge of soak.identify_coverage can fail.
#include "host_tests/property/identify/coverage_limits.h"

#include <gtest/gtest.h>

namespace m100::host_tests {
namespace {

std::size_t offences(const char* name, int asked, int answered, int covered) {
  return outside_limits({{name, {.asked = asked, .answered = answered, .covered = covered}}}).size();
}

TEST(CoverageLimits, HoldsEveryParameterToTheGoal) {
  EXPECT_EQ(offences("roll delay_s", 500, 490, 460), 0U);
  EXPECT_EQ(offences("roll delay_s", 500, 490, 436), 1U) << "89 % of the intervals hold the truth";
  EXPECT_EQ(offences("roll delay_s", 500, 490, 490), 1U) << "intervals that always hold it are too wide";
  EXPECT_EQ(offences("roll delay_s", 12, 12, 10), 0U) << "twelve logs cannot tell 83 from 92 %";
}

// Catches a judge that one log with another structure disables, and one that passes if every log is refused.
TEST(CoverageLimits, WantsAnswers) {
  EXPECT_EQ(offences("roll delay_s", 500, 499, 400), 1U);
  EXPECT_EQ(offences("roll delay_s", 500, 430, 410), 1U);
  EXPECT_EQ(offences("roll delay_s", 500, 0, 0), 1U);
  EXPECT_EQ(outside_limits({}).size(), 1U);
}

}  // namespace
}  // namespace m100::host_tests
