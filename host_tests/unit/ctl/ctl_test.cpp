// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "firmware/ctl/altitude_pid.h"
#include "firmware/ctl/yaw_p.h"
#include "firmware/model/paper.h"

namespace m100::ctl {
namespace {

TEST(AltitudePid, StartsFromThePapersGains) {
  RecordProperty("paper", "III-E.2");
  const model::AltitudeGains gains;
  EXPECT_EQ(gains.proportional_per_s, model::paper::kAltitudeKp);
  EXPECT_EQ(gains.integral_per_s2, model::paper::kAltitudeKi);
  EXPECT_EQ(gains.derivative, model::paper::kAltitudeKd);
  EXPECT_EQ(gains.integral_max_m_s, model::paper::kAltitudeIntegralLimit);
  AltitudePid<double> pid(gains);
  EXPECT_NEAR(pid.update(1.0, 0.0, 0.9, 0.0, 0.01), 1.963 * 0.1 + 6.190 * 0.1 * 0.01, 1e-12);
}

TEST(AltitudePid, TheIntegralKeepsItsLimits) {
  AltitudePid<double> pid{model::AltitudeGains{}};
  for (int i = 0; i < 1000; ++i) {
    pid.update(1.0, 0.0, 0.9, 0.0, 0.01);
  }
  EXPECT_NEAR(pid.integral_m_s(), 0.2, 1e-12);
  EXPECT_NEAR(pid.update(0.9, 0.0, 0.9, 0.0, 0.01), 0.2, 1e-12);
}

// Catches wind-up: while the output is at its limit the integral must not grow.
TEST(AltitudePid, StandsStillWhileTheOutputIsAtItsLimit) {
  AltitudePid<double> pid{model::AltitudeGains{}};
  for (int i = 0; i < 1000; ++i) {
    EXPECT_LE(pid.update(10.0, 0.0, 0.0, 0.0, 0.01), 2.0);
  }
  EXPECT_EQ(pid.integral_m_s(), 0.0);
}

// Catches a derivative of the error: a step of the reference must not kick.
TEST(AltitudePid, DampsTheMeasuredClimbSpeedOnly) {
  model::AltitudeGains gains;
  gains.integral_per_s2 = 0.0;
  AltitudePid<double> pid(gains);
  EXPECT_NEAR(pid.update(1.1, 0.0, 1.0, 0.0, 0.01), 1.963 * 0.1, 1e-12);
  EXPECT_NEAR(pid.update(1.1, 0.0, 1.0, 0.5, 0.01), 1.963 * 0.1 - 0.156 * 0.5, 1e-12);
}

struct Turn {
  const char* name;
  double wanted_rad, yaw_rad, rate_rad_s;
};
class YawTurns : public ::testing::TestWithParam<Turn> {};

// Catches the long way round.
TEST_P(YawTurns, GoTheShortWay) {
  const YawP<double> yaw(model::YawGain{.proportional_per_s = 1.5, .rate_limit_rad_s = 1.0});
  EXPECT_NEAR(yaw.update(GetParam().wanted_rad, 0.0, GetParam().yaw_rad), GetParam().rate_rad_s, 1e-9);
}
INSTANTIATE_TEST_SUITE_P(Table, YawTurns,
                         ::testing::Values(Turn{"SmallLeft", 0.1, 0.0, 0.15}, Turn{"SmallRight", -0.1, 0.0, -0.15},
                                           Turn{"OverPi", -3.1, 3.1, 1.5 * (2 * core::kPi - 6.2)},
                                           Turn{"UnderMinusPi", 3.1, -3.1, -1.5 * (2 * core::kPi - 6.2)},
                                           Turn{"Limited", 3.0, 0.0, 1.0}),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace m100::ctl
