// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/paper_state.h"

#include <gtest/gtest.h>

#include <limits>

namespace m100::ctl {
namespace {

est::Estimate<double> estimate() {
  est::Estimate<double> out;
  out.x = {.position_m = 0.1, .velocity_m_s = 0.2, .tilt_rad = 0.3, .disturbance_m_s2 = 0.5, .input_offset_rad = 0.02};
  out.y = {.position_m = -0.2, .tilt_rad = 0.4, .disturbance_m_s2 = -0.1, .input_offset_rad = 0.03};
  out.x.measured_tilt_rad = 0.31;
  out.y.measured_tilt_rad = 0.42;
  return out;
}

// One second beside the reference: the integral is that of the error, with the authors' gain and sign. Catches the
// model's tilt, the observer's input offset, and an integral that pushes away from the reference.
TEST(PaperState, IsTheMeasuredTiltWithoutAnOffsetAndAnIntegralInTheDisturbance) {
  PaperState<double> state;
  const est::Estimate<double> flown = estimate();
  for (int tick = 0; tick < 100; ++tick) {
    state.update(flown, {}, 0.01);
  }
  EXPECT_EQ(state.x().position_m, 0.1);
  EXPECT_EQ(state.x().velocity_m_s, 0.2);
  EXPECT_EQ(state.x().tilt_rad, 0.31);
  EXPECT_EQ(state.y().tilt_rad, 0.42);
  EXPECT_EQ(state.x().input_offset_rad, 0.0);
  EXPECT_NEAR(state.x().disturbance_m_s2, 0.5 + 0.2 * 0.1, 1e-12);
  EXPECT_NEAR(state.y().disturbance_m_s2, -0.1 - 0.2 * 0.2, 1e-12);
  state.reset();
  state.update(flown, {}, 0.0);
  EXPECT_EQ(state.x().disturbance_m_s2, 0.5);
}

// The ball of 0.4 m counts all three axes. Catches a ball of the horizontal error alone, and one that only pauses.
TEST(PaperState, ForgetsItsIntegralWhileTheReferenceIsFarAndLimitsItWhereItIsNear) {
  PaperState<double> state;
  est::Estimate<double> flown = estimate();
  state.update(flown, {}, 1.0);
  flown.height_m = 0.34;  // 0.407 m with x and y
  state.update(flown, {}, 1.0);
  EXPECT_EQ(state.x().disturbance_m_s2, 0.5);
  flown.height_m = 0.32;  // 0.39 m
  for (int second = 0; second < 100; ++second) {
    state.update(flown, {}, 1.0);
  }
  EXPECT_NEAR(state.x().disturbance_m_s2, 0.5 + 0.2 * 2.0, 1e-12);
}

// Catches an integral that stays no number after one position that was none.
TEST(PaperState, ForgetsAPositionThatIsNoNumber) {
  PaperState<double> state;
  est::Estimate<double> flown = estimate();
  flown.x.position_m = std::numeric_limits<double>::quiet_NaN();
  state.update(flown, {}, 1.0);
  state.update(estimate(), {}, 0.0);
  EXPECT_EQ(state.x().disturbance_m_s2, 0.5);
  EXPECT_EQ(state.y().disturbance_m_s2, -0.1);
}

TEST(PaperState, LeavesPositionsAndVelocitiesOfTheReference) {
  ref::Window<double> window;
  window.x[20] = window.y[0] = window.height = {1.0, 2.0, 3.0};
  remove_accelerations(window);
  for (const ref::AxisReference<double>& point : {window.x[20], window.y[0], window.height}) {
    EXPECT_EQ(point.position_m, 1.0);
    EXPECT_EQ(point.velocity_m_s, 2.0);
    EXPECT_EQ(point.acceleration_m_s2, 0.0);
  }
}

}  // namespace
}  // namespace m100::ctl
