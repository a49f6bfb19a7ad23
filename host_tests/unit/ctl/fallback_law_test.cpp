// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/fallback_law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "firmware/model/vehicle.h"

namespace m100::ctl {
namespace {

constexpr double kStep_s = 0.01;
constexpr Braking kBraking{.acceleration_m_s2 = 3.8, .max_disturbance_m_s2 = 3.8, .reaction_s = 0.35};

mpc::GainTable<double> table() {
  mpc::GainTable<double> out;
  out.input_min_slope = -0.46;
  out.input_max_slope = 0.46;
  out.tilt_sign = -1.0;
  out.acceleration_per_tilt = model::kGravity_m_s2;
  out.input_gain = 1.0;
  return out;
}

/// Flies an aircraft along y with a total lag of `lag_s` and a gain of `gain`, from 0.3 m beside its place.
/// @returns how far it leaves it in the second half of the time
double farthest_m(double lag_s, double gain) {
  const mpc::GainTable<double> limits = table();
  FallbackLaw<double> law;
  std::deque<double> pipe(static_cast<std::size_t>(lag_s / kStep_s), 0.0);
  est::AxisEstimate<double> y{.position_m = 0.3};
  double out_m = 0.0;
  constexpr int kTicks = 4000;
  for (int k = 0; k < kTicks; ++k) {
    pipe.push_back(law.slope(y, {}, limits, fallback_rate_per_s<double>(kBraking), kStep_s));
    y.velocity_m_s += kStep_s * -model::kGravity_m_s2 * gain * pipe.front();
    y.position_m += kStep_s * y.velocity_m_s;
    pipe.pop_front();
    out_m = k > kTicks / 2 ? std::max(out_m, std::abs(y.position_m)) : out_m;
  }
  return out_m;
}

// The purpose of this law: it stays stable with the whole lag of the vehicle, 0.2 s more, and 50 % more gain.
TEST(FallbackLaw, StandsHalfMoreGainAndTwoTenthsOfASecond) {
  EXPECT_NEAR(fallback_rate_per_s<double>(kBraking), 0.463 / 0.55, 1e-12);
  const double whole_s = kBraking.reaction_s + 0.18;  // the motion still dies out, slowly
  EXPECT_LT(farthest_m(whole_s, 1.5), 0.05);
  EXPECT_LT(farthest_m(whole_s, 1.0), 0.001);
  EXPECT_GT(farthest_m(whole_s + 0.35, 1.5), 0.3) << "nor is it slower than it says";
}

// The header's equation by hand, at the limits of its table too.
TEST(FallbackLaw, IsItsEquationWithinTheLimitsOfTheTableBesideATrim) {
  mpc::GainTable<double> gains = table();
  gains.input_gain = 0.8;
  gains.drag_per_s = 0.25;
  gains.input_max_slope = 0.5;
  const auto slope = [&](double position_m, double velocity_m_s) {
    FallbackLaw<double> law;
    return law.slope({position_m, velocity_m_s, 0.0, 0.0, 0.6, 0.05}, {1.0, 0.4, 0.3}, gains, 0.9, kStep_s);
  };
  constexpr double kTrim_rad = 0.05;  // beside a slope s it counts (1 + s^2) of it
  const double wind = 0.6 / (0.8 * model::kGravity_m_s2);
  const auto wanted = [wind](double nearer_m_s, double velocity_m_s) {
    const double wanted_m_s2 = 0.3 + 0.25 * 0.4 + 1.8 * (0.4 + nearer_m_s - velocity_m_s);
    return -wanted_m_s2 / (0.8 * model::kGravity_m_s2) + wind - kTrim_rad * (1.0 + wind * wind);
  };
  EXPECT_NEAR(slope(0.2, 0.1), wanted(0.45 * 0.8, 0.1), 1e-12);
  EXPECT_NEAR(slope(-9.0, 0.1), wanted(1.0, 0.1), 1e-12);
  EXPECT_NEAR(slope(9.0, 0.1), wanted(-1.0, 0.1), 1e-12);
  EXPECT_DOUBLE_EQ(slope(0.0, -8.0), -0.46 - kTrim_rad * (1.0 + 0.46 * 0.46));
  EXPECT_DOUBLE_EQ(slope(0.0, 8.0), 0.5 - kTrim_rad * (1.0 + 0.5 * 0.5));
}

// The estimates of wind and trim oscillate with an oscillating aircraft, so they pass a low-pass filter that starts at
// their first values.
TEST(FallbackLaw, TakesWindAndTrimSlowly) {
  FallbackLaw<double> law;
  est::AxisEstimate<double> y{.disturbance_m_s2 = model::kGravity_m_s2 * 0.1};
  EXPECT_NEAR(law.slope(y, {}, table(), 0.84, kStep_s), 0.1, 1e-12);
  y.disturbance_m_s2 = 0.0;
  EXPECT_NEAR(law.slope(y, {}, table(), 0.84, kStep_s), 0.1 * (1.0 - 0.0084), 1e-12);
  EXPECT_NEAR(law.slope(y, {}, table(), 0.84, 2.0), 0.0, 1e-12) << "a stall: at most all of it";
  y.input_offset_rad = 0.1;
  law.reset();
  EXPECT_NEAR(law.slope(y, {}, table(), 0.84, kStep_s), -0.1, 1e-12);
}

}  // namespace
}  // namespace m100::ctl
