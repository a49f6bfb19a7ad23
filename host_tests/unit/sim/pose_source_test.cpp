// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/pose_source.h"

#include <gtest/gtest.h>
#include <cmath>
#include <vector>

namespace m100::sim {
namespace {

using std::chrono::milliseconds;

/// What arrives in `ticks` ticks of 2.5 ms from a vehicle that moves at 1 m/s in x.
std::vector<std::pair<core::TimePoint, PoseSample>> record(PoseSource& source, int ticks) {
  std::vector<std::pair<core::TimePoint, PoseSample>> out;
  for (int i = 0; i < ticks; ++i) {
    const core::TimePoint now(std::chrono::microseconds(2500 * i));
    VehicleState truth;
    truth.position_w_m.x() = 0.0025 * i;
    while (const auto sample = source.step(now, truth, 0.5)) {
      out.emplace_back(now, *sample);
    }
  }
  return out;
}

TEST(PoseSource, DeliversAHundredPosesASecondTwentyMillisecondsOld) {
  PoseSource source(Sensors{}, 1);
  const auto poses = record(source, 400);
  EXPECT_EQ(poses.size(), 98U);
  for (const auto& [arrival, pose] : poses) {
    EXPECT_EQ(arrival - pose.captured, milliseconds(20));
    EXPECT_NEAR(pose.position_w_m.x(), core::seconds<double>(pose.captured.time_since_epoch()), 0.006);  // 6 sigma
  }
}

TEST(PoseSource, IsSilentFrozenWrongOrNotANumberWhenToldSo) {
  PoseSource silent(Sensors{}, 1);
  silent.set_faults({.silent = true});
  EXPECT_TRUE(record(silent, 100).empty());

  PoseSource frozen(Sensors{}, 1);
  frozen.set_faults({.frozen = true});
  const auto poses = record(frozen, 100);
  EXPECT_EQ(poses.front().second.position_w_m, poses.back().second.position_w_m);
  EXPECT_NE(poses.front().second.captured, poses.back().second.captured);

  PoseSource broken(Sensors{}, 1);
  broken.set_faults({.not_finite = true});
  EXPECT_TRUE(std::isnan(record(broken, 100).front().second.position_w_m.x()));

  PoseSource turned(Sensors{}, 1);
  turned.set_faults({.turn_rad = core::kPi});
  EXPECT_NEAR(record(turned, 400).back().second.position_w_m.x(), -0.97, 0.01);
}

TEST(PoseSource, DropsOutAsOftenAndAsLongAsStated) {
  PoseSource source({.pose_dropout_per_s = 1.0, .pose_dropout_s = 0.1}, 5);
  const auto poses = record(source, 400 * 100);
  // A dropout begins only while poses come or go: expected share lost 0.1 / 1.1, three sigmas of 100 dropouts.
  EXPECT_NEAR(static_cast<double>(poses.size()), 10000.0 * (1.0 - 0.1 / 1.1), 300.0);
}

}  // namespace
}  // namespace m100::sim
