// SPDX-License-Identifier: BSD-3-Clause
// A sample of the adversarial logs; soak.identify_adversarial_logs covers the whole matrix.
#include "host_tests/property/identify/adversarial_log.h"

#include <gtest/gtest.h>

namespace m100::host_tests {
namespace {

class AdversarialLogTest : public ::testing::TestWithParam<std::string> {};

// Catches a "nothing missing" that the data do not support, and a name for an effect that is not there.
TEST_P(AdversarialLogTest, IsAnsweredRightOrNotAtAll) {
  RecordProperty("promise", "R13");
  for (const std::uint64_t seed : {9001U, 9002U}) {
    const AdversarialLog truth = adversarial_log(GetParam(), seed);
    const lab::identify::IdentifyResult result = identify_log(truth);
    const Classification answer = classify(truth, result);
    EXPECT_TRUE(answer == Classification::kRight || (answer == Classification::kUndecided && !truth.healthy))
        << "seed " << seed << ": " << static_cast<int>(answer) << ", " << result.verdict;
  }
}

std::string letters(const ::testing::TestParamInfo<std::string>& info) {
  std::string out;
  for (const char c : info.param) {
    out += (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ? std::string(1, c) : "";
  }
  return out;
}

INSTANTIATE_TEST_SUITE_P(Table, AdversarialLogTest, ::testing::ValuesIn(adversarial_log_kinds()), letters);

// A change must be named, dated and measured: its intervals must contain the true time and size.
TEST(AdversarialChange, IsDatedAndMeasured) {
  int inside = 0;
  int measured = 0;
  int found = 0;
  for (std::uint64_t seed = 9001; seed <= 9006; ++seed) {
    const AdversarialLog truth = adversarial_log("gain changes 10 to 25 %", seed);
    for (const auto& change : identify_log(truth).changes) {
      ++found;
      inside += change.low_s - 0.3 <= truth.change_s && truth.change_s <= change.high_s + 0.3 ? 1 : 0;
      const double size = truth.change_size * change.parameters.front().value;
      measured += change.size && change.size->low <= size && size <= change.size->high ? 1 : 0;
    }
  }
  EXPECT_EQ(found, 6);
  EXPECT_GE(inside, 5);
  EXPECT_GE(measured, 5);
}

}  // namespace
}  // namespace m100::host_tests
