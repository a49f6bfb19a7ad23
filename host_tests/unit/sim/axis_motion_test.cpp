// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/axis_motion.h"

#include <gtest/gtest.h>
#include <cmath>

namespace m100::sim {
namespace {

constexpr model::StickAxis kPlain{.scale_per_count = 1e-3, .natural_frequency_rad_s = 9.0, .damping_ratio = 0.68};

struct Case {
  const char* name;
  model::StickAxis law;
  double stick_counts;
  double expected;
};

model::StickAxis with(void (*change)(model::StickAxis&)) {
  model::StickAxis law = kPlain;
  change(law);
  return law;
}

class StickLaw : public ::testing::TestWithParam<Case> {};

// Catches a dead zone, curve, trim or asymmetry that is applied in the wrong order or to the wrong side.
TEST_P(StickLaw, AnswersTheStick) {
  AxisMotion axis(GetParam().law);
  axis.set_stick(GetParam().stick_counts);
  EXPECT_NEAR(axis.commanded(), GetParam().expected, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(
    Table, StickLaw,
    ::testing::Values(
        Case{"Linear", kPlain, 1124.0, 0.1},
        Case{"TrimIsTakenFirst", with([](model::StickAxis& law) { law.trim_counts = 56.0; }), 1080.0, 0.0},
        Case{"DeadZoneSwallows", with([](model::StickAxis& law) { law.dead_zone_counts = 20.0; }), 1043.0, 0.0},
        Case{"DeadZoneContinuous", with([](model::StickAxis& law) { law.dead_zone_counts = 20.0; }), 1074.0, 0.03},
        Case{"DeadZoneJump", with([](model::StickAxis& law) {
               law.dead_zone_counts = 20.0;
               law.dead_zone_shape = model::DeadZoneShape::kJump;
             }),
             974.0, -0.05},
        Case{"AsymmetryKeepsTheMean", with([](model::StickAxis& law) { law.gain_asymmetry = 1.5; }), 1124.0, 0.12},
        Case{"AsymmetryOtherSide", with([](model::StickAxis& law) { law.gain_asymmetry = 1.5; }), 924.0, -0.08},
        Case{"CurveKeepsTheEnds", with([](model::StickAxis& law) { law.stick_exponent = 2.0; }), 1684.0, 0.66},
        Case{"CurveFlattensTheMiddle", with([](model::StickAxis& law) { law.stick_exponent = 2.0; }), 1354.0, 0.165},
        Case{"BacklashLags", with([](model::StickAxis& law) { law.backlash_counts = 10.0; }), 1054.0, 0.02}),
    [](const auto& tested) { return tested.param.name; });

// The textbook step response of a second-order system; midpoint steps of 1 ms are accurate to 1e-4.
TEST(AxisMotion, FollowsTheTextbookStepAfterItsDelay) {
  model::StickAxis law = kPlain;
  law.transport_delay_s = 0.033;
  AxisMotion axis(law);
  axis.set_stick(1124.0);
  const double wd = 9.0 * std::sqrt(1.0 - 0.68 * 0.68);
  for (int i = 1; i <= 1000; ++i) {
    axis.advance(0.001, 0.0);
    const double t = i * 0.001 - 0.033;
    const double expected =
        t <= 0.0 ? 0.0
                 : 0.1 * (1.0 - std::exp(-0.68 * 9.0 * t) * (std::cos(wd * t) + 0.68 * 9.0 / wd * std::sin(wd * t)));
    ASSERT_NEAR(axis.output(), expected, 1e-4) << "at " << i << " ms";
  }
}

TEST(AxisMotion, NeverTurnsFasterThanItsRateLimit) {
  model::StickAxis law = kPlain;
  law.rate_limit_per_s = 0.2;
  AxisMotion axis(law);
  axis.set_stick(1424.0);
  for (int i = 0; i < 500; ++i) {
    axis.advance(0.001, 0.0);
    ASSERT_LE(std::abs(axis.output_rate()), 0.2 + 1e-9);
  }
}

TEST(AxisMotion, DriftsByItsShareInAMinute) {
  model::StickAxis law = kPlain;
  law.gain_drift_per_minute = 0.1;
  AxisMotion axis(law);
  for (int i = 0; i < 60000; ++i) {
    axis.advance(0.001, 0.0);
  }
  axis.set_stick(1124.0);
  EXPECT_NEAR(axis.commanded(), 0.11, 1e-6);
}

}  // namespace
}  // namespace m100::sim
