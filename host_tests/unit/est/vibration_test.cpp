// SPDX-License-Identifier: BSD-3-Clause
// Vibration of the specific force: how it is measured, and that it contradicts no pose.
#include "firmware/est/vibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "firmware/est/consistency/velocity_consistency.h"

namespace m100::est {
namespace {

// White noise, a tone of the motion and one of a rotor. Catches a level that depends on the rate of the messages, and a
// motion that is taken for vibration.
TEST(Vibration, IsWhatLiesAboveFifteenHertzAtAnyRate) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  using Vector3 = core::Vector<double, 3>;
  const auto after = [](double interval_s, const std::function<Vector3(double t_s)>& force_m_s2) {
    Vibration<double> vibration;
    for (double t_s = 0.0; t_s < 60.0; t_s += interval_s) {
      const Vector3 force = force_m_s2(t_s);
      vibration.update(force, force.cwiseAbs().maxCoeff(), interval_s, 3.0);
    }
    return vibration;
  };
  for (const double interval_s : {0.005, 0.01, 0.02}) {
    const Vibration<double> white =
        after(interval_s, [&](double) { return Vector3(normal(random), normal(random), normal(random)); });
    EXPECT_NEAR(white.density_m2_s3().horizontal, interval_s, 0.3 * interval_s);
    EXPECT_NEAR(white.density_m2_s3().vertical, interval_s, 0.4 * interval_s);
    EXPECT_GT(white.peak_m_s2(), 2.0 * white.rms_m_s2());
    EXPECT_FALSE(white.is_too_slow());
    EXPECT_EQ(white.clipped(), 0.0);
  }
  const auto tone = [&](double frequency_hz) {
    return after(0.01, [=](double t_s) {
      return Vector3(0.0, 0.0, 3.0 * std::sqrt(2.0) * std::sin(2.0 * core::kPi * frequency_hz * t_s));
    });
  };
  EXPECT_LT(tone(3.0).rms_m_s2(), 0.05 * 3.0 / std::sqrt(3.0));
  EXPECT_NEAR(tone(15.0).rms_m_s2(), 3.0 / 2.0 / std::sqrt(3.0), 0.05);
  EXPECT_GT(tone(40.0).rms_m_s2(), 0.9 * 3.0 / std::sqrt(3.0));
  EXPECT_TRUE(after(1.0 / 25.0, [](double) { return Vector3(0.0, 0.0, 0.0); }).is_too_slow());
  EXPECT_NEAR(after(0.01, [](double) { return Vector3(78.5, 0.0, 0.0); }).clipped(), 1.0, 1e-6) << "8 g";
}

// The force of a hover shakes: no pose is contradicted, and the unit of the force stays known. A pose that stands while
// the force shows a larger acceleration is still named.
TEST(Vibration, ContradictsNoPoseAndHidesNoLargerFault) {
  RecordProperty("promise", "R14, R17");
  for (const double vibration_m_s2 : {0.5, 2.0, 5.0, 8.0}) {
    VelocityConsistency<double> check(set_of(ConsistencyCheck::kMotion));
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0.0, vibration_m_s2);
    Estimate<double> estimate;
    estimate.healthy = true;
    const auto shake = [&](double seconds, double false_m_s2) {
      for (double t_s = 0.0; t_s < seconds; t_s += 0.01) {
        ImuSample<double> imu{.attitude_is_new = true, .force_is_new = true};
        imu.force_b = {false_m_s2 + noise(random), noise(random), 9.8066 + noise(random)};
        check.update(imu, estimate, core::Vector<double, 2>::Zero(), core::kTickPeriod);
        EXPECT_TRUE(false_m_s2 > 0.0 || check.report().check == ConsistencyCheck::kNone) << vibration_m_s2;
      }
    };
    shake(120.0, 0.0);
    EXPECT_EQ(check.force_scale_m_s2(), 1.0) << vibration_m_s2;
    shake(3.0, 0.8 + vibration_m_s2);
    EXPECT_EQ(check.report().check, ConsistencyCheck::kForce) << vibration_m_s2;
  }
}

}  // namespace
}  // namespace m100::est
