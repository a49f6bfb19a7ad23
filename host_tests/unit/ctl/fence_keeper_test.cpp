// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/fence_keeper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "firmware/ctl/settle.h"

namespace m100::ctl {
namespace {

core::Fence box() { return {.side = {core::Fence::Side{-5, 5}, core::Fence::Side{-5, 5}, core::Fence::Side{0.5, 4}}}; }

ref::Window<double> goal(double x_m, double z_m) {
  ref::Window<double> window;
  window.x.fill({.position_m = x_m, .velocity_m_s = 1.0});
  window.height = {.position_m = z_m};
  window.constant = true;
  return window;
}

TEST(FenceKeeper, HoldsGoalsInsideAndLeavesTheOthersAlone) {
  FenceKeeper<double> keeper(box());
  ref::Window<double> window = goal(100.0, -3.0);
  keeper.hold(window, {});
  EXPECT_EQ(window.x[0].position_m, 4.8);
  EXPECT_EQ(window.x[20].velocity_m_s, 0.0);
  EXPECT_EQ(window.height.position_m, 0.7);
  window = goal(2.0, 1.5);
  keeper.hold(window, {});
  EXPECT_EQ(window.x[5].position_m, 2.0);
  EXPECT_EQ(window.x[5].velocity_m_s, 1.0);
  EXPECT_FALSE(keeper.brakes());
}

TEST(FenceKeeper, WithoutAFenceNothingIsHeld) {
  FenceKeeper<double> keeper{core::Fence{}};
  ref::Window<double> window = goal(100.0, 50.0);
  est::Estimate<double> fast;
  fast.x.velocity_m_s = 8.0;
  keeper.hold(window, fast);
  EXPECT_EQ(window.x[0].position_m, 100.0);
  EXPECT_FALSE(keeper.brakes());
}

/// Way of an aircraft that brakes with all its tilt: the attitude follows a command that is 95 ms late (transport and
/// command period) as the measured axes do (second order, 6.2 rad/s, damping 0.71); the wind pushes, with gusts.
double way_to_a_stop(double speed_m_s, double tilt_rad, double wind_m_s2) {
  constexpr double kStep_s = 1e-3, kLimit = 0.4363, kW = 6.2, kZeta = 0.71;
  double x_m = 0.0, v = speed_m_s, angle = tilt_rad, rate = 0.0;
  for (double t_s = 0.0; v > 0.0 && t_s < 10.0; t_s += kStep_s) {
    const double wanted = t_s < 0.095 ? tilt_rad : -kLimit;
    rate += kStep_s * (kW * kW * (wanted - angle) - 2.0 * kZeta * kW * rate);
    angle += kStep_s * rate;
    v += kStep_s * (9.8066 * std::tan(angle) + wind_m_s2 + 0.45);  // 0.3 1/s x 30 % of 5 m/s in the worst phase
    x_m += kStep_s * v;
  }
  return x_m;
}

// By construction: whatever state is admitted, full braking ends inside. Catches a reserve that forgets the way until
// the attitude has turned, the speed that is still gained meanwhile, or the wind.
TEST(FenceKeeper, EveryAdmittedStateStopsInside) {
  RecordProperty("promise", "R16");
  FenceKeeper<double> keeper(box());
  int admitted = 0;
  for (double speed = 0.5; speed <= 6.0; speed += 0.5) {
    for (const double tilt : {-0.4, 0.0, 0.2, 0.4}) {
      for (const double wind : {0.0, 0.75, 1.5}) {
        est::Estimate<double> estimate;
        estimate.x = {.position_m = -4.0, .velocity_m_s = speed, .tilt_rad = tilt, .disturbance_m_s2 = wind};
        ref::Window<double> window = goal(4.0, 1.5);
        keeper.hold(window, estimate);
        const double stops_m = -4.0 + way_to_a_stop(speed, tilt, wind);
        if (keeper.reserve_m() >= 0.0) {
          ++admitted;
          EXPECT_LT(stops_m, 5.0) << speed << " m/s, tilt " << tilt << ", wind " << wind;
          EXPECT_LT(stops_m + keeper.reserve_m(), 5.0 + 0.05) << speed << " m/s, tilt " << tilt << ", wind " << wind;
        } else {
          EXPECT_TRUE(keeper.brakes());
          EXPECT_LT(window.x[0].position_m, -4.0) << "a goal behind the aircraft";
        }
      }
    }
  }
  EXPECT_GT(admitted, 50);
}

TEST(Settle, BrakesThenHoldsTrimAndWind) {
  est::Estimate<double> estimate;
  estimate.predicts = true;
  estimate.x = {
      .velocity_m_s = 4.0, .disturbance_m_s2 = 1.0, .input_offset_rad = 0.02, .velocity_variance_m2_s2 = 0.01};
  EXPECT_NEAR(settle(estimate).pitch_rad, std::atan((-4.0 - 1.0) / 9.8066 - 0.02), 1e-12);
  estimate.x.velocity_m_s = 0.0;
  EXPECT_NEAR(settle(estimate).pitch_rad, std::atan(-1.0 / 9.8066 - 0.02), 1e-12);
  estimate.x.velocity_m_s = 4.0;
  estimate.x.velocity_variance_m2_s2 = 2.0;  // worthless
  EXPECT_NEAR(settle(estimate).pitch_rad, std::atan(-1.0 / 9.8066 - 0.02), 1e-12);
  estimate.predicts = false;
  EXPECT_EQ(settle(estimate).pitch_rad, 0.0);
}

// Catches a limit of each axis alone: 4 m/s over the diagonal against wind tilted by 35 degrees, and a large wind,
// beyond 50, was unsound and became no command at all.
TEST(Settle, TiltsBothAxesTogetherByThirtyDegreesAtMost) {
  for (const double yaw_rad : {0.0, 0.7, -2.0}) {
    for (const double wind_m_s2 : {1.0, 3.0, 20.0}) {
      est::Estimate<double> estimate;
      estimate.predicts = true;
      estimate.yaw_rad = yaw_rad;
      estimate.x = {.velocity_m_s = 4.0, .disturbance_m_s2 = wind_m_s2, .velocity_variance_m2_s2 = 0.01};
      estimate.y = {.velocity_m_s = 4.0, .disturbance_m_s2 = wind_m_s2, .velocity_variance_m2_s2 = 0.01};
      const Command<double> command = settle(estimate);
      const double tilt_rad = std::acos(std::cos(command.roll_rad) * std::cos(command.pitch_rad));
      EXPECT_NEAR(tilt_rad, core::kPi / 6.0, 1e-9) << yaw_rad << " " << wind_m_s2;
      if (yaw_rad == 0.0) {
        EXPECT_LT(command.pitch_rad, 0.0);
        EXPECT_GT(command.roll_rad, 0.0);
      }
    }
  }
}

}  // namespace
}  // namespace m100::ctl
