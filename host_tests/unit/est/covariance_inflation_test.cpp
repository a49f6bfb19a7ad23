// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/covariance_inflation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "firmware/est/filter/disturbance_ekf.h"

namespace m100::est {
namespace {

constexpr double kPose_s = 0.01;
constexpr CovarianceInflation<double>::Covariance kOwn{.pp_m2 = 1e-6, .pv_m2_s = 5e-6, .vv_m2_s2 = 1e-4};

/// A watch that has seen a steady lag: every pose corrects position, velocity and disturbance by the same amounts.
CovarianceInflation<double> lagging(double p_m, double v_m_s, double a_m_s2, double nis) {
  CovarianceInflation<double> watch;
  for (int k = 0; k < 3000; ++k) {
    watch.update(p_m, v_m_s * kPose_s, a_m_s2 * kPose_s, nis, kPose_s);
  }
  return watch;
}

// Catches a claimed variance without the lag, and one that counts corrections per pose instead of per second.
TEST(CovarianceInflation, ASteadyPushIsClaimedAsTheErrorThatItCorrects) {
  const auto inflated = lagging(0.002, 0.05, 0.3, 1.0).inflated(kOwn, 0.0, 0.0);
  EXPECT_NEAR(inflated.pp_m2 - kOwn.pp_m2, 0.002 * 0.002, 1e-8);
  EXPECT_NEAR(inflated.vv_m2_s2 - kOwn.vv_m2_s2, 0.05 * 0.05, 1e-5);
  EXPECT_EQ(inflated.pv_m2_s, kOwn.pv_m2_s) << "how position and velocity go together is not claimed";
}

// Catches a claimed error that does not grow while no pose comes: p + v t + a t^2 / 2 and v + a t.
TEST(CovarianceInflation, WithoutAPoseTheErrorGrowsAsItsRateSays) {
  const auto inflated = lagging(0.002, 0.05, 0.3, 1.0).inflated(kOwn, 0.5, 0.48);
  const double p_m = 0.002 + 0.05 * 0.5 + 0.5 * 0.3 * 0.25;
  const double v_m_s = 0.05 + 0.3 * 0.48;
  EXPECT_NEAR(std::sqrt(inflated.pp_m2 - kOwn.pp_m2), p_m, 0.02 * p_m);
  EXPECT_NEAR(std::sqrt(inflated.vv_m2_s2 - kOwn.vv_m2_s2), v_m_s, 0.02 * v_m_s);
}

// Catches a prediction that is called useless although the measured force supports it: the LEVEL state would give up
// braking in motion.
TEST(CovarianceInflation, AMeasuredAccelerationIsWrongByItsOffsetAlone) {
  const auto inflated = lagging(0.002, 0.05, 1.0, 1.0).inflated(kOwn, 1.0, 1.0, true);
  EXPECT_NEAR(std::sqrt(inflated.pp_m2 - kOwn.pp_m2), std::hypot(0.052, 0.1), 0.002);
  EXPECT_NEAR(std::sqrt(inflated.vv_m2_s2 - kOwn.vv_m2_s2), std::hypot(0.05, 0.2), 0.002);
}

TEST(CovarianceInflation, ADropoutOfAMinuteIsClaimedLikeOneOfASecond) {
  const CovarianceInflation<double> watch = lagging(0.002, 0.05, 0.3, 1.0);
  EXPECT_EQ(watch.inflated(kOwn, 60.0, 60.0).pp_m2, watch.inflated(kOwn, 1.0, 1.0).pp_m2);
  EXPECT_EQ(watch.inflated(kOwn, 60.0, 60.0).vv_m2_s2, watch.inflated(kOwn, 1.0, 1.0).vv_m2_s2);
}

// Catches noise that is taken for a lag: calm air would be reported as a storm.
TEST(CovarianceInflation, NoiseFromPoseToPoseIsNoLag) {
  CovarianceInflation<double> watch;
  std::mt19937 random(7);
  std::normal_distribution<> noise(0.0, 0.002);
  for (int k = 0; k < 3000; ++k) {
    const double innovation_m = noise(random);
    watch.update(innovation_m, 0.2 * innovation_m, 2.0 * innovation_m, 1.0, kPose_s);
  }
  const auto inflated = watch.inflated(kOwn, 0.02, 0.0);
  EXPECT_LT(inflated.pp_m2 - kOwn.pp_m2, 0.05 * 0.002 * 0.002);
  EXPECT_LT(inflated.vv_m2_s2 - kOwn.vv_m2_s2, 0.05 * 0.04 * 0.04);
}

TEST(CovarianceInflation, AClaimThatIsTooLargeShrinksToHalfASigmaAndOnlyWhilePosesCome) {
  EXPECT_NEAR(lagging(0.0, 0.0, 0.0, 0.5).inflated(kOwn, 0.02, 0.01).pp_m2, 0.5 * kOwn.pp_m2, 1e-9);
  EXPECT_NEAR(lagging(0.0, 0.0, 0.0, 0.1).inflated(kOwn, 0.02, 0.01).vv_m2_s2, 0.25 * kOwn.vv_m2_s2, 1e-8);
  EXPECT_EQ(lagging(0.0, 0.0, 0.0, 0.1).inflated(kOwn, 0.2, 0.2).pp_m2, kOwn.pp_m2);
  EXPECT_EQ(lagging(0.0, 0.0, 0.0, 4.0).inflated(kOwn, 0.02, 0.01).pp_m2, kOwn.pp_m2);
}

/// Ratio of the claimed to the true mean square error of the velocity, in a hover in an oscillating wind.
double claimed_over_true(double gust_m_s2, double pulsation_rad_s) {
  model::Vehicle vehicle;
  vehicle.climb.time_constant_s = 0.334;
  vehicle.estimator.disturbance_process_m_s2 = 0.13;
  vehicle.estimator.pose_position_sigma_m = 0.0018;
  DoubleEkf filter(vehicle);
  std::mt19937 random(5);
  std::normal_distribution<> noise(0.0, 0.001);
  double inflated = 0.0, error = 0.0;
  for (int tick = 0; tick < 3000; ++tick) {
    const double t_s = 0.01 * tick;
    const double x_m = -gust_m_s2 / (pulsation_rad_s * pulsation_rad_s) * std::sin(pulsation_rad_s * t_s);
    const double v_m_s = -gust_m_s2 / pulsation_rad_s * std::cos(pulsation_rad_s * t_s);
    Measurement<double> m;
    m.now = core::TimePoint(std::chrono::milliseconds(10 * tick));
    m.attitude.is_new = true;
    m.pose.is_new = true;
    m.pose.arrived = m.now;
    m.pose.position_w_m = {x_m + noise(random), noise(random), 1.0};
    m.pose.set_captured_at(m.now);
    const Estimate<double> estimate = filter.update(m, {}, core::kTickPeriod);
    if (tick > 1500) {
      inflated += estimate.x.velocity_variance_m2_s2;
      error += (estimate.x.velocity_m_s - v_m_s) * (estimate.x.velocity_m_s - v_m_s);
    }
  }
  return inflated / error;
}

// Once, in a wind of 8 m/s, the observer claimed 11 mm/s while its error was 59 mm/s: a thirtieth of the square.
TEST(CovarianceInflation, TheObserverClaimsWhatItIsWrongByInGusts) {
  for (const double gust_m_s2 : {0.0, 0.3, 1.0, 2.0}) {
    for (const double pulsation_rad_s : {0.7, 1.3, 2.5}) {
      const double ratio = claimed_over_true(gust_m_s2, pulsation_rad_s);
      EXPECT_GT(ratio, 0.5) << gust_m_s2 << " m/s^2, " << pulsation_rad_s << " rad/s";
      EXPECT_LT(ratio, 5.0) << gust_m_s2 << " m/s^2, " << pulsation_rad_s << " rad/s";
    }
  }
}

}  // namespace
}  // namespace m100::est
