// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/monitor/stall_monitor.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace m100::companion {
namespace {

struct Lines final : OperatorLog {
  void write(core::TimePoint, std::string_view line) override { heard.emplace_back(line); }
  std::vector<std::string> heard;
};

TEST(StallMonitor, SpeaksOnceForEachTickThatComesTooLateAndOfNoOther) {
  Lines lines;
  StallMonitor watch(lines);
  core::TimePoint now{std::chrono::hours(1)};  // the first tick follows none
  watch.tick(now);
  watch.tick(now += StallMonitor::kReportedStall);
  EXPECT_TRUE(lines.heard.empty());
  watch.tick(now += StallMonitor::kReportedStall + core::Duration{1000});
  ASSERT_EQ(lines.heard.size(), 1U);
  EXPECT_EQ(lines.heard[0].find("this program stood still for 0.051 s: "), 0U) << lines.heard[0];
  watch.tick(now += core::kTickPeriod);
  EXPECT_EQ(lines.heard.size(), 1U);
}

}  // namespace
}  // namespace m100::companion
