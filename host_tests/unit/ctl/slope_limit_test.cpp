// SPDX-License-Identifier: BSD-3-Clause
// How far the tilt limit is lowered when the aircraft tilts beyond it.
#include "firmware/ctl/law/slope_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "firmware/ctl/law/brake_and_hold.h"
#include "firmware/mpc/generated/gain_table.h"

namespace m100::ctl {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
const double kLimit = std::tan(30.0 * kDegree);

TEST(SlopeLimit, TakesTwiceWhatIsBeyondTheLimitAndNeverMoreThanHalf) {
  EXPECT_EQ(max_slope(0.0, 0.0, kLimit), kLimit);
  EXPECT_EQ(max_slope(0.4, -0.4, kLimit), kLimit) << "inside, both axes together";
  EXPECT_NEAR(max_slope(0.48, -0.36, kLimit), kLimit - 2.0 * (0.6 - kLimit), 1e-12);
  EXPECT_EQ(max_slope(3.0, 0.0, kLimit), 0.5 * kLimit) << "pushed over by a hand: what is left can still right it";
  EXPECT_EQ(max_slope(std::numeric_limits<double>::quiet_NaN(), 0.0, kLimit), kLimit);
}

// R12: an aircraft with a trim error, too high a gain and overshoot. Catches a limit of the command alone: 30 degrees
// with a gain of 1.05, a trim of 3 degrees and overshoot make 36.7.
TEST(SlopeLimit, KeepsTheTiltOfAnAircraftThatDoesNotFollow) {
  RecordProperty("promise", "R12");
  constexpr double kStep_s = 0.01, kPulsation_rad_s = 7.0, kDamping = 0.6, kGain = 1.05;
  constexpr int kDelay = 6, kHeld = 4;  // ticks
  const double trim = std::tan(3.0 * kDegree);
  std::array<double, kDelay> pipe{};
  est::AxisEstimate<double> axis;
  double slope = -kLimit, rate = 0.0, commanded = 0.0, worst = 0.0;
  for (int tick = 0; tick < 400; ++tick) {
    axis.tilt_rate_rad_s = rate / (1.0 + slope * slope);
    if (tick % kHeld == 0) {
      commanded = max_slope(predicted_slope(axis, slope, 0.01 * (kDelay + kHeld)), 0.0, kLimit);
    }
    const double acts = kGain * pipe[static_cast<std::size_t>(tick % kDelay)] + trim;
    pipe[static_cast<std::size_t>(tick % kDelay)] = commanded;
    rate += kStep_s * (kPulsation_rad_s * kPulsation_rad_s * (acts - slope) - 2.0 * kDamping * kPulsation_rad_s * rate);
    slope += kStep_s * rate;
    worst = std::max(worst, slope);
  }
  EXPECT_LT(std::atan(worst) / kDegree, 34.0);
  EXPECT_NEAR(std::atan(slope) / kDegree, 31.5, 0.5) << "at rest a third of the error is left";
}

// Catches a LEVEL state that commands its full tilt although the aircraft already tilts further, or is about to, and a
// limit of each axis alone: over the diagonal against a wind the aircraft then tilted by 50 degrees.
TEST(SlopeLimit, IsKeptByTheCommandThatBrakes) {
  const Braking braking = ctl::braking_of(mpc::generated::kVehicle, 0.5);
  est::Estimate<double> fast;
  fast.prediction_valid = true;
  fast.x.velocity_m_s = 12.0;
  fast.y.velocity_m_s = 12.0;
  for (const double share : {0.4, 0.9, 0.95}) {
    fast.yaw_rad = 7.0 * share - 4.0;
    fast.x.disturbance_m_s2 = fast.y.disturbance_m_s2 = 20.0 * share - 8.0;
    fast.x.tilt_rad = -30.0 * share * kDegree;
    fast.x.tilt_rate_rad_s = -0.2;
    fast.y.tilt_rad = 20.0 * share * kDegree;
    fast.y.tilt_rate_rad_s = 0.4;
    const Command<double> command = brake_and_hold(fast, braking);
    const double slope = std::tan(std::acos(std::cos(command.roll_rad) * std::cos(command.pitch_rad)));
    const auto predicted_slope = [&](const est::AxisEstimate<double>& axis) {
      const double now = std::tan(axis.tilt_rad);
      return now + braking.acts_s * axis.tilt_rate_rad_s * (1.0 + now * now);
    };
    const double together = std::hypot(predicted_slope(fast.x), predicted_slope(fast.y));
    EXPECT_NEAR(slope, kLimit - 2.0 * std::max(together - kLimit, 0.0), 1e-9) << share;
    EXPECT_EQ(slope<0.99 * kLimit, share> 0.5);
  }
}

}  // namespace
}  // namespace m100::ctl
