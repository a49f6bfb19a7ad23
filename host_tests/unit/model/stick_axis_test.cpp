// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/model/stick_axis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "firmware/model/axis_effects.h"

namespace m100::model {
namespace {

constexpr double kPeriod_s = 0.01;

// Would catch a lost bit of the exponent, or a series that is too short; libm is the second implementation.
TEST(Power, AgreesWithLibm) {
  for (double x = 0.001; x < 8.0; x *= 1.37) {
    for (double exponent = 0.3; exponent < 4.1; exponent += 0.31) {
      EXPECT_NEAR(power(x, exponent) / std::pow(x, exponent), 1.0, 1e-11) << x << "^" << exponent;
    }
  }
  EXPECT_EQ(power(0.0, 1.5), 0.0);
}

struct LawCase {
  std::string name;
  StickAxis axis;
  double stick;
  double other;
  double expected;
};

StickAxis unit_gain() {
  StickAxis axis;
  axis.scale_per_count = 1.0;
  return axis;
}

LawCase make(const std::string& name, double stick, double other, double expected, void (*change)(StickAxis&)) {
  LawCase out{name, unit_gain(), stick, other, expected};
  change(out.axis);
  return out;
}

class StickLawTable : public ::testing::TestWithParam<LawCase> {};

TEST_P(StickLawTable, GivesTheCommandOfItsEquation) {
  StickLaw<double> law(GetParam().axis, kPeriod_s);
  EXPECT_NEAR(law.command(GetParam().stick, GetParam().other, 60.0), GetParam().expected, 1e-9);
}

using M = StickAxis;
INSTANTIATE_TEST_SUITE_P(
    Table, StickLawTable,
    ::testing::Values(make("PlainGain", 100, 0, 100, [](M&) {}),
                      make("TrimComesBeforeTheDeadZone", 30, 0, 5,
                           [](M& m) { m.trim_counts = 10, m.dead_zone_counts = 15; }),
                      make("ContinuousDeadZoneCountsFromItsEdge", -50, 0, -30, [](M& m) { m.dead_zone_counts = 20; }),
                      make("JumpDeadZonePassesTheWholeStick", -50, 0, -50,
                           [](M& m) { m.dead_zone_counts = 20, m.dead_zone_shape = DeadZoneShape::kJump; }),
                      make("InsideTheDeadZoneNothingPasses", 19, 0, 0, [](M& m) { m.dead_zone_counts = 20; }),
                      make("CurveKeepsFullTravel", 660, 0, 660, [](M& m) { m.stick_exponent = 1.6; }),
                      make("CurveSoftensTheMiddle", 330, 0, 165, [](M& m) { m.stick_exponent = 2.0; }),
                      make("AsymmetryKeepsTheMeanGain", 100, 0, 120, [](M& m) { m.gain_asymmetry = 1.5; }),
                      make("AsymmetryOfTheOtherSide", -100, 0, -80, [](M& m) { m.gain_asymmetry = 1.5; }),
                      make("DriftAfterOneMinute", 100, 0, 80, [](M& m) { m.gain_drift_per_minute = -0.2; }),
                      make("OtherStickLeaksIn", 100, 50, 90, [](M& m) { m.cross_axis = -0.2; }),
                      make("SaturationClampsTheCommand", -100, 0, -60, [](M& m) { m.saturation = 60; }),
                      make("TiltLimitShortensTheVector", 30, 40, 15, [](M& m) { m.tilt_limit = 25; })),
    [](const auto& tested) { return tested.param.name; });

// The backlash follows the stick at half its width and holds when the stick turns back inside it.
TEST(StickLaw, BacklashFollowsAndHolds) {
  M axis = unit_gain();
  axis.backlash_counts = 10.0;
  StickLaw<double> law(axis, kPeriod_s);
  EXPECT_NEAR(law.command(0.0, 0.0, 0.0), 0.0, 1e-12);
  EXPECT_NEAR(law.command(50.0, 0.0, 0.0), 40.0, 1e-12);
  EXPECT_NEAR(law.command(35.0, 0.0, 0.0), 40.0, 1e-12);
  EXPECT_NEAR(law.command(20.0, 0.0, 0.0), 30.0, 1e-12);
}

// Catches a slew limit that also applies to the first command, applies in one direction only, or counts per sample.
TEST(StickLaw, SlewLimitsEachStepOfTheCommandButNotItsBeginning) {
  M axis = unit_gain();
  axis.command_slew_per_s = 500.0;
  StickLaw<double> law(axis, kPeriod_s);
  EXPECT_NEAR(law.command(100.0, 0.0, 0.0), 100.0, 1e-12);
  EXPECT_NEAR(law.command(112.0, 0.0, 0.0), 105.0, 1e-12);
  EXPECT_NEAR(law.command(112.0, 0.0, 0.0), 110.0, 1e-12);
  EXPECT_NEAR(law.command(112.0, 0.0, 0.0), 112.0, 1e-12) << "arrived";
  EXPECT_NEAR(law.command(0.0, 0.0, 0.0), 107.0, 1e-12);
}

// The tilt of both axes is limited as one vector, each axis with its own scale; below the limit nothing changes.
TEST(StickLaw, TiltLimitTakesTheOtherAxisByItsOwnScale) {
  M axis = unit_gain();
  axis.tilt_limit = 25.0;
  axis.other_scale_per_count = 2.0;
  EXPECT_NEAR(StickLaw<double>(axis, kPeriod_s).command(30.0, 20.0, 0.0), 15.0, 1e-12);
  EXPECT_NEAR(StickLaw<double>(axis, kPeriod_s).command(12.0, 8.0, 0.0), 12.0, 1e-12);
}

// Catches a member of the struct without a row in the table: files, fits and reports would not know it. The command
// slew is the one exception; it is the rate limit in another place.
TEST(AxisEffects, EveryNumberOfTheStructHasARow) {
  std::size_t rows = 0;
  for_each_axis_number([&](const AxisNumber&) { ++rows; });
  constexpr std::size_t kShape = sizeof(double);  // the dead zone's shape, padded
  EXPECT_EQ(rows, (sizeof(StickAxis) - kShape) / sizeof(double) - 1);
}

// Catches a neutral value that has an effect: the size of the fitted effect would be measured from the wrong value.
TEST(AxisEffects, ANewAxisHasNoEffects) {
  const StickAxis plain;
  for (const AxisEffect& effect : kAxisEffects) {
    for (const AxisNumber& number : effect.numbers) {
      EXPECT_EQ(plain.*number.member, number.neutral) << effect.name;
    }
  }
}

// Catches two effects with the same name, an effect that refers to an unknown one, and an effect without starts for the
// fit.
TEST(AxisEffects, NamesAreUniqueAndReferToEffects) {
  EXPECT_EQ(axis_effect("no such effect"), nullptr);
  std::set<std::string_view> names;
  for (const AxisEffect& effect : kAxisEffects) {
    EXPECT_TRUE(names.insert(effect.name).second) << effect.name;
    EXPECT_TRUE(effect.needs.empty() || axis_effect(effect.needs) != nullptr) << effect.name;
    EXPECT_TRUE(effect.not_beside.empty() || axis_effect(effect.not_beside) != nullptr) << effect.name;
    EXPECT_GT(effect.starts.size(), 0U) << effect.name;
    for (const AxisNumber& number : effect.numbers) {
      EXPECT_LT(number.fit.low, number.fit.high) << effect.name;
      EXPECT_TRUE(!number.logarithmic || number.fit.low > 0.0) << effect.name;
    }
  }
}

}  // namespace
}  // namespace m100::model
