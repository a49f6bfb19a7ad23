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

// Catches a LEVEL state that commands its full tilt although the aircraft already tilts further.
TEST(SlopeLimit, IsKeptByTheCommandThatBrakes) {
  const Braking braking = ctl::braking_of(mpc::generated::kVehicle, 0.408);
  est::Estimate<double> fast;
  fast.prediction_valid = true;
  fast.x.velocity_m_s = 6.0;
  fast.y.velocity_m_s = 6.0;
  const auto reported_rad = [&](double tilt_rad) {
    fast.x.tilt_rad = -tilt_rad;
    fast.y.tilt_rad = tilt_rad;
    const Command<double> command = brake_and_hold(fast, braking);
    return std::acos(std::cos(command.roll_rad) * std::cos(command.pitch_rad));
  };
  EXPECT_GT(reported_rad(10.0 * kDegree) / kDegree, 28.0);
  EXPECT_LT(reported_rad(25.0 * kDegree) / kDegree, 24.0) << "33.4 degrees together";
}

}  // namespace
}  // namespace m100::ctl
