// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/preflight/wake_up_check.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace m100::companion::preflight {
namespace {

using namespace std::chrono_literals;

TEST(WakeUpCheck, JudgesByTheWorstAndByThoseThatAFlightWouldCount) {
  EXPECT_EQ(judge_wake_ups({.ticks = 500, .late = 0, .worst = 20ms, .real_time = true}).health, Health::kGood);
  EXPECT_EQ(judge_wake_ups({.ticks = 500, .late = 1, .worst = 21ms, .real_time = true}).health, Health::kDoubtful);
  EXPECT_EQ(judge_wake_ups({.ticks = 500, .late = 1, .worst = 50ms, .real_time = true}).health, Health::kDoubtful);
  EXPECT_EQ(judge_wake_ups({.ticks = 500, .late = 1, .worst = 51ms, .real_time = true}).health, Health::kBad);
}

TEST(WakeUpCheck, SaysTheNumbersAndTheRemedy) {
  const CheckResult late = judge_wake_ups({.ticks = 501, .late = 7, .worst = 63200us, .real_time = false});
  EXPECT_EQ(
      late.finding,
      "with every processor and the disk busy, 501 ticks of 10 ms were up to 63.2 ms late, 7 of them more than 20 "
      "ms (without real-time rights)");
  EXPECT_NE(late.remedy.find("isolcpus"), std::string::npos);
  const CheckResult good = judge_wake_ups({.ticks = 501, .late = 0, .worst = 300us, .real_time = true});
  EXPECT_EQ(good.finding.find("rights"), std::string::npos);
  EXPECT_TRUE(good.remedy.empty());
}

// Times are not judged here, because this machine may be busy by itself.
TEST(WakeUpCheck, MeasuresEveryTickAndLeavesNoFile) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "m100_wake_ups";
  std::filesystem::create_directories(folder);
  const WakeUps measured = measure_wake_ups(folder.string(), 100ms);
  EXPECT_EQ(measured.ticks, 10U);
  EXPECT_GT(measured.worst, 0us);
  EXPECT_LE(measured.late, measured.ticks);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  std::filesystem::remove(folder);
}

}  // namespace
}  // namespace m100::companion::preflight
