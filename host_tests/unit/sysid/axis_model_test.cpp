// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/sysid/axis_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace m100::sysid {
namespace {

constexpr double kPeriod_s = 0.01;

// Would catch a lost exponent bit or a short series: libm is the second implementation.
TEST(Power, AgreesWithLibm) {
  for (double x = 0.001; x < 8.0; x *= 1.37) {
    for (double exponent = 0.3; exponent < 4.1; exponent += 0.31) {
      EXPECT_NEAR(power(x, exponent) / std::pow(x, exponent), 1.0, 1e-11) << x << "^" << exponent;
    }
  }
  EXPECT_EQ(power(0.0, 1.5), 0.0);
}

// Would catch Euler steps or an input held at the wrong side of the sample: the closed form of the step response.
TEST(AxisDynamics, SecondOrderStepIsExact) {
  AxisModel<double> model;
  model.natural_frequency_rad_s = 8.69;
  model.damping_ratio = 0.68;
  AxisDynamics<double> dynamics(model, kPeriod_s);
  dynamics.start(0.0, 0.0);
  const double w = 8.69;
  const double z = 0.68;
  const double wd = w * std::sqrt(1.0 - z * z);
  for (int k = 1; k <= 100; ++k) {
    const double t = k * kPeriod_s;
    const double exact = 1.0 - std::exp(-z * w * t) * (std::cos(wd * t) + z * w / wd * std::sin(wd * t));
    EXPECT_NEAR(dynamics.step(1.0), exact, 1e-12) << "after " << t << " s";
  }
}

// Overdamped and fast: the series of the matrix exponential must still converge at the edge of the permitted range.
TEST(AxisDynamics, OverdampedFastAxisSettlesAtTheCommand) {
  AxisModel<double> model;
  model.natural_frequency_rad_s = 50.0;
  model.damping_ratio = 4.0;
  AxisDynamics<double> dynamics(model, kPeriod_s);
  dynamics.start(-0.3, 1.0);
  for (int k = 0; k < 400; ++k) {
    dynamics.step(0.2);
  }
  EXPECT_NEAR(dynamics.value(), 0.2, 1e-9);
  EXPECT_NEAR(dynamics.rate_per_s(), 0.0, 1e-8);
}

TEST(AxisDynamics, RateLimitHoldsInEveryStep) {
  AxisModel<double> model;
  model.natural_frequency_rad_s = 9.0;
  model.damping_ratio = 0.7;
  model.rate_limit_per_s = 0.5;
  AxisDynamics<double> dynamics(model, kPeriod_s);
  dynamics.start(0.0, 2.0);
  double before = 0.0;
  for (int k = 0; k < 200; ++k) {
    const double now = dynamics.step(k < 100 ? 0.4 : -0.4);
    EXPECT_LE(std::abs(now - before), 0.5 * kPeriod_s * (1.0 + 1e-12));
    before = now;
  }
}

struct LawCase {
  std::string name;
  AxisModel<double> model;
  double stick;
  double other;
  double expected;
};

AxisModel<double> unit_gain() {
  AxisModel<double> model;
  model.gain = 1.0;
  return model;
}

LawCase make(const std::string& name, double stick, double other, double expected, void (*change)(AxisModel<double>&)) {
  LawCase out{name, unit_gain(), stick, other, expected};
  change(out.model);
  return out;
}

class StaticLawTable : public ::testing::TestWithParam<LawCase> {};

TEST_P(StaticLawTable, GivesTheCommandOfItsEquation) {
  StaticLaw<double> law(GetParam().model, kPeriod_s);
  EXPECT_NEAR(law.command(GetParam().stick, GetParam().other, 60.0), GetParam().expected, 1e-9);
}

using M = AxisModel<double>;
INSTANTIATE_TEST_SUITE_P(
    Table, StaticLawTable,
    ::testing::Values(make("PlainGain", 100, 0, 100, [](M&) {}),
                      make("TrimComesBeforeTheDeadZone", 30, 0, 5,
                           [](M& m) { m.trim_counts = 10, m.dead_zone_counts = 15; }),
                      make("ContinuousDeadZoneCountsFromItsEdge", -50, 0, -30, [](M& m) { m.dead_zone_counts = 20; }),
                      make("JumpDeadZonePassesTheWholeStick", -50, 0, -50,
                           [](M& m) { m.dead_zone_counts = 20, m.dead_zone_shape = model::DeadZoneShape::kJump; }),
                      make("InsideTheDeadZoneNothingPasses", 19, 0, 0, [](M& m) { m.dead_zone_counts = 20; }),
                      make("CurveKeepsFullTravel", 660, 0, 660, [](M& m) { m.stick_exponent = 1.6; }),
                      make("CurveSoftensTheMiddle", 330, 0, 165, [](M& m) { m.stick_exponent = 2.0; }),
                      make("AsymmetryKeepsTheMeanGain", 100, 0, 120, [](M& m) { m.gain_asymmetry = 1.5; }),
                      make("AsymmetryOfTheOtherSide", -100, 0, -80, [](M& m) { m.gain_asymmetry = 1.5; }),
                      make("DriftAfterOneMinute", 100, 0, 80, [](M& m) { m.gain_drift_per_s = -0.2 / 60; }),
                      make("OtherStickLeaksIn", 100, 50, 90, [](M& m) { m.cross_axis = -0.2; }),
                      make("SaturationClampsTheCommand", -100, 0, -60, [](M& m) { m.saturation = 60; }),
                      make("TiltLimitShortensTheVector", 30, 40, 15, [](M& m) { m.tilt_limit = 25; })),
    [](const auto& tested) { return tested.param.name; });

// The play follows the stick by its half width, and stays when the stick turns back inside of it.
TEST(StaticLaw, BacklashFollowsAndHolds) {
  M model = unit_gain();
  model.backlash_counts = 10.0;
  StaticLaw<double> law(model, kPeriod_s);
  EXPECT_NEAR(law.command(0.0, 0.0, 0.0), 0.0, 1e-12);
  EXPECT_NEAR(law.command(50.0, 0.0, 0.0), 40.0, 1e-12);
  EXPECT_NEAR(law.command(35.0, 0.0, 0.0), 40.0, 1e-12);
  EXPECT_NEAR(law.command(20.0, 0.0, 0.0), 30.0, 1e-12);
}

}  // namespace
}  // namespace m100::sysid
