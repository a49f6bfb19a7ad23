// SPDX-License-Identifier: BSD-3-Clause
// Tracking error at each command rate, as in the table of experiments/README.md.
#include <gtest/gtest.h>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/experiments/rates.h"

namespace m100::lab::experiments {
namespace {

// Catches a rate that never reaches the wire (all rows equal), and one that costs more than its delay explains.
TEST(CommandRates, AFasterRateNeverTracksWorseOnItsChannelAndNoRateIsLost) {
  SuiteOptions options;
  options.plant = sim::measured_plant();
  options.vehicle = companion::as_file(mpc::generated::kVehicle);
  options.only = "hover";
  const std::vector<RateCost> costs = fly_rates(options);
  ASSERT_EQ(costs.size(), rate_settings().size());
  for (std::size_t i = 0; i < costs.size(); ++i) {
    for (std::size_t task = 0; task < costs[i].tasks.size(); ++task) {
      const TaskResult& result = costs[i].tasks[task];
      SCOPED_TRACE(std::to_string(costs[i].setting.rate_hz) + " Hz, " + result.task->condition);
      ASSERT_EQ(result.refused, 0);
      EXPECT_EQ(result.mean.off_nominal_share, 0.0);
      EXPECT_LE(result.mean.pose_m, result.task->paper->pose_m);
      if (i > 0 && costs[i - 1].setting.channel == costs[i].setting.channel) {
        const double slower_m = costs[i - 1].tasks[task].mean.pose_m;
        EXPECT_LT(result.mean.pose_m, slower_m);
        EXPECT_GT(result.mean.pose_m, 0.7 * slower_m);
      }
    }
  }
}

}  // namespace
}  // namespace m100::lab::experiments
