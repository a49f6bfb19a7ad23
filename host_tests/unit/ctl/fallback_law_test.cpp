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
  out.input_min_rad = -0.46;
  out.input_max_rad = 0.46;
  out.tilt_sign = -1.0;
  out.acceleration_per_tilt = model::kGravity_m_s2;
  out.input_gain = 1.0;
  return out;
}

struct Flown {
  double worst_m = 0.0;  ///< in the second half of the time
  double far_m = 0.0;    ///< in all of it, beyond the place
};

/// Flies an aircraft along y with a total lag of `lag_s` and a gain of `gain`, from `from_m`, under a steady push.
Flown fly(double lag_s, double gain, double from_m, double disturbance_acceleration_m_s2) {
  const mpc::GainTable<double> limits = table();
  FallbackLaw<double> law;
  std::deque<double> pipe(static_cast<std::size_t>(lag_s / kStep_s), 0.0);
  est::AxisEstimate<double> y{.position_m = from_m, .disturbance_m_s2 = disturbance_acceleration_m_s2};
  Flown out;
  constexpr int kTicks = 4000;
  for (int k = 0; k < kTicks; ++k) {
    pipe.push_back(law.slope(y, {}, limits, fallback_rate_per_s<double>(kBraking), kStep_s));
    y.velocity_m_s += kStep_s * (disturbance_acceleration_m_s2 - model::kGravity_m_s2 * gain * pipe.front());
    y.position_m += kStep_s * y.velocity_m_s;
    pipe.pop_front();
    out.worst_m = k > kTicks / 2 ? std::max(out.worst_m, std::abs(y.position_m)) : out.worst_m;
    out.far_m = std::max(out.far_m, -y.position_m);
  }
  return out;
}

TEST(FallbackLaw, IsAsQuickAsTheVehicleAllows) {
  EXPECT_NEAR(fallback_rate_per_s<double>(kBraking), 0.463 / 0.55, 1e-12);
}

// The purpose of this law: it stays stable with the whole lag of the vehicle, 0.2 s more, and 50 % more gain.
TEST(FallbackLaw, StandsHalfMoreGainAndTwoTenthsOfASecond) {
  const double whole_s = kBraking.reaction_s + 0.18;  // the motion still dies out, slowly
  EXPECT_LT(fly(whole_s, 1.5, 0.3, 0.0).worst_m, 0.05);
  EXPECT_LT(fly(whole_s, 1.0, 0.3, 0.0).worst_m, 0.001);
  EXPECT_GT(fly(whole_s + 0.35, 1.5, 0.3, 0.0).worst_m, 0.3) << "nor is it slower than it says";
}

TEST(FallbackLaw, GoesFarAtAMetrePerSecondAndStopsThere) {
  const Flown far = fly(kBraking.reaction_s, 1.0, 10.0, 0.0);
  EXPECT_LT(far.far_m, 0.05);
  EXPECT_LT(far.worst_m, 0.02);
}

TEST(FallbackLaw, HoldsAgainstTheWindThatIsEstimated) {
  EXPECT_LT(fly(kBraking.reaction_s, 1.0, 0.0, 2.0).worst_m, 0.01);
}

TEST(FallbackLaw, KeepsTheLimitsOfTheTableBesideATrim) {
  FallbackLaw<double> law;
  const est::AxisEstimate<double> flees{.velocity_m_s = -8.0, .input_offset_rad = 0.05};
  EXPECT_DOUBLE_EQ(law.slope(flees, {}, table(), 0.84, kStep_s), -0.46 - 0.05);
}

// The estimates of wind and trim oscillate with an oscillating aircraft, so they pass a low-pass filter that starts at
// their first values.
TEST(FallbackLaw, TakesWindAndTrimSlowly) {
  FallbackLaw<double> law;
  est::AxisEstimate<double> y{.disturbance_m_s2 = model::kGravity_m_s2 * 0.1};
  EXPECT_NEAR(law.slope(y, {}, table(), 0.84, kStep_s), 0.1, 1e-12);
  y.disturbance_m_s2 = 0.0;
  EXPECT_NEAR(law.slope(y, {}, table(), 0.84, kStep_s), 0.1 * (1.0 - 0.0084), 1e-12);
  law.reset();
  EXPECT_NEAR(law.slope(y, {}, table(), 0.84, kStep_s), 0.0, 1e-12);
}

}  // namespace
}  // namespace m100::ctl
