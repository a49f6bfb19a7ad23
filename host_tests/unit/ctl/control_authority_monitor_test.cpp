// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/monitor/control_authority_monitor.h"

#include <gtest/gtest.h>

namespace m100::ctl {
namespace {

constexpr Braking kBraking{.acceleration_m_s2 = 3.8, .max_disturbance_m_s2 = 3.8, .reaction_s = 0.35};

/// Shows the watch one constant state for `time_s`, with a reference at 0.
double lost_after(double time_s, const est::AxisEstimate<double>& y) {
  ControlAuthorityMonitor<double> watch(kBraking);
  est::Estimate<double> estimate;
  estimate.y = y;
  for (int k = 0; k < static_cast<int>(time_s * 100.0); ++k) {
    watch.update(estimate, {}, true, 0.01);
  }
  return watch.exceeded_s();
}

// Catches an alarm in a wind that can be held, in a gust, and on a long way upwind; and an alarm that works in one
// direction only.
TEST(ControlAuthorityMonitor, SpeaksWhereAStrongWindKeepsTheAircraftAway) {
  const est::AxisEstimate<double> kLost{.position_m = -0.55, .velocity_m_s = 0.18, .disturbance_m_s2 = -4.5};
  EXPECT_GT(lost_after(7.0, kLost), 3.0);
  EXPECT_EQ(lost_after(2.0, kLost), 0.0) << "the wind is averaged";
  EXPECT_GT(lost_after(7.0, {.position_m = 1.0, .disturbance_m_s2 = 4.5}), 3.0);
  EXPECT_EQ(lost_after(7.0, {.position_m = -0.45, .disturbance_m_s2 = -4.5}), 0.0) << "it is held";
  EXPECT_EQ(lost_after(7.0, {.position_m = 1.0, .disturbance_m_s2 = -4.5}), 0.0) << "it is upwind of its place";
  EXPECT_EQ(lost_after(7.0, {.position_m = -3.0, .velocity_m_s = 0.22, .disturbance_m_s2 = -4.5}), 0.0) << "it comes";
  EXPECT_EQ(lost_after(7.0, {.position_m = -3.0, .disturbance_m_s2 = -3.75}), 0.0) << "a wind that it holds against";
}

TEST(ControlAuthorityMonitor, IsSilentWhereTheLawDoesNotFly) {
  ControlAuthorityMonitor<float> watch(kBraking);
  est::Estimate<float> estimate;
  estimate.x = {.position_m = 2.F, .disturbance_m_s2 = 5.F};
  for (int k = 0; k < 800; ++k) {
    watch.update(estimate, {}, true, 0.01F);
  }
  EXPECT_GT(watch.exceeded_s(), 3.F);
  EXPECT_NEAR(watch.disturbance_acceleration_m_s2(), 5.F, 0.2F);
  watch.update(estimate, {}, false, 0.01F);
  EXPECT_EQ(watch.exceeded_s(), 0.F);
}

}  // namespace
}  // namespace m100::ctl
