// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/monitor/control_authority_monitor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace m100::ctl {
namespace {

constexpr Braking kBraking{.acceleration_m_s2 = 5.0, .max_disturbance_m_s2 = 3.8, .reaction_s = 0.35};

/// What one step of 2 s counts as lost [s]; after it the mean is the disturbance itself.
double lost_s(bool on_x, double away_m, double velocity_m_s, double disturbance_m_s2) {
  ControlAuthorityMonitor<double> monitor(kBraking);
  est::Estimate<double> estimate;
  ref::Window<double> window;
  window.x[0].position_m = estimate.x.position_m = 7.0;
  window.y[0].position_m = estimate.y.position_m = -4.0;
  est::AxisEstimate<double>& axis = on_x ? estimate.x : estimate.y;
  axis = {axis.position_m + away_m, velocity_m_s, 0.0, 0.0, disturbance_m_s2};
  monitor.update(estimate, window, true, 2.0);
  EXPECT_EQ(monitor.status().exceeded_for, monitor.exceeded_s() * std::chrono::seconds(1));
  EXPECT_EQ(monitor.status().disturbance_acceleration_m_s2, std::abs(disturbance_m_s2));
  return monitor.exceeded_s();
}

// Both sides of each bound, on both axes and in both directions.
TEST(ControlAuthorityMonitor, SpeaksWhereAStrongWindKeepsTheAircraftAway) {
  for (const bool on_x : {true, false}) {
    for (const double wind : {1.0, -1.0}) {
      EXPECT_EQ(lost_s(on_x, 0.52 * wind, -0.19 * wind, 3.85 * wind), 2.0);
      EXPECT_EQ(lost_s(on_x, 0.5 * wind, 0.0, 3.85 * wind), 0.0) << "it is held";
      EXPECT_EQ(lost_s(on_x, -1.0 * wind, 0.0, 4.5 * wind), 0.0) << "it is upwind of its place";
      EXPECT_EQ(lost_s(on_x, 3.0 * wind, -0.2 * wind, 3.85 * wind), 0.0) << "it comes back";
      EXPECT_EQ(lost_s(on_x, 3.0 * wind, 0.0, 3.8 * wind), 0.0) << "a wind that it holds against";
    }
  }
}

TEST(ControlAuthorityMonitor, AveragesTheWindAndIsSilentWhereTheLawDoesNotFly) {
  ControlAuthorityMonitor<float> watch(kBraking);
  est::Estimate<float> estimate;
  estimate.x = {.position_m = 2.F, .disturbance_m_s2 = 5.F};
  watch.update(estimate, {}, true, 0.5F);
  EXPECT_NEAR(watch.disturbance_acceleration_m_s2(), 5.F * 0.25F, 1e-6F);
  EXPECT_EQ(watch.exceeded_s(), 0.F) << "a gust";
  for (int k = 0; k < 800; ++k) {
    watch.update(estimate, {}, true, 0.01F);
  }
  EXPECT_NEAR(watch.exceeded_s(), 8.F - 2.F * std::log(3.75F / 1.2F), 0.05F);
  EXPECT_NEAR(watch.disturbance_acceleration_m_s2(), 5.F, 0.1F);
  watch.update(estimate, {}, true, 3.F);
  EXPECT_EQ(watch.disturbance_acceleration_m_s2(), 5.F) << "a stall: never beyond the estimate";
  watch.update(estimate, {}, false, 0.01F);
  EXPECT_EQ(watch.exceeded_s(), 0.F);
}

}  // namespace
}  // namespace m100::ctl
