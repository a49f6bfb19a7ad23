// SPDX-License-Identifier: BSD-3-Clause
// The effect of each translation effect on one moment, or on a series of thrust, compared with its equation by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "firmware/model/translation.h"

namespace m100::model {
namespace {

/// Heading 90 degrees, tilted by 30 degrees along x, in an airflow of (3, 4, -12) m/s: 13 m/s in total.
Moment turned_left() {
  return {.time_s = 10.25,
          .air_velocity_w_m_s = {3.0, 4.0, -12.0},
          .thrust_w_m_s2 = {5.0, 1.0, 8.0},
          .up_b_in_w = {0.5, 0.0, std::sqrt(0.75)},
          .heading_cosine = 0.0,
          .heading_sine = 1.0};
}

struct ColumnCase {
  std::string effect;
  std::size_t which;
  double searched;
  Acceleration expected;
};
class Column : public ::testing::TestWithParam<ColumnCase> {};

TEST_P(Column, IsTheAccelerationOfItsEquation) {
  const TranslationEffect* const effect = translation_effect(GetParam().effect);
  ASSERT_NE(effect, nullptr);
  ASSERT_LT(GetParam().which, effect->columns);
  const Acceleration seen = effect->column(GetParam().which, turned_left(), GetParam().searched);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(seen[axis], GetParam().expected[axis], 1e-12) << "axis " << axis;
  }
}

/// Airflow along the rotor axis, m/s.
const double kAlong_m_s = 1.5 - 12.0 * std::sqrt(0.75);

INSTANTIATE_TEST_SUITE_P(
    Table, Column,
    ::testing::Values(
        ColumnCase{"steady_wind", 0, 0.0, {1.0, 0.0, 0.0}}, ColumnCase{"steady_wind", 1, 0.0, {0.0, 1.0, 0.0}},
        ColumnCase{"body_bias", 0, 0.0, {0.0, 1.0, 0.0}},   // forward is +y
        ColumnCase{"body_bias", 1, 0.0, {-1.0, 0.0, 0.0}},  // left is -x
        ColumnCase{"linear_drag", 0, 0.0, {-3.0, -4.0, 12.0}},
        ColumnCase{"quadratic_drag", 0, 0.0, {-39.0, -52.0, 156.0}}, ColumnCase{"body_drag", 0, 0.0, {0.0, -4.0, 0.0}},
        ColumnCase{"body_drag", 1, 0.0, {-3.0, 0.0, 0.0}}, ColumnCase{"tilt_gain", 0, 0.0, {5.0, 1.0, 0.0}},
        ColumnCase{"thrust_gain", 0, 0.0, {5.0, 1.0, 8.0}},
        ColumnCase{"axial_inflow", 0, 0.0, {-0.5 * kAlong_m_s, 0.0, -std::sqrt(0.75) * kAlong_m_s}},
        // 0.2 Hz after 10.25 s: two turns and a twentieth of a turn, which is 18 degrees.
        ColumnCase{"periodic_wind", 0, 0.2, {std::cos(std::numbers::pi / 10.0), 0.0, 0.0}},
        ColumnCase{"periodic_wind", 1, 0.2, {std::sin(std::numbers::pi / 10.0), 0.0, 0.0}},
        ColumnCase{"periodic_wind", 2, 0.2, {0.0, std::cos(std::numbers::pi / 10.0), 0.0}},
        ColumnCase{"periodic_wind", 3, 0.2, {0.0, std::sin(std::numbers::pi / 10.0), 0.0}}),
    [](const auto& tested) { return tested.param.effect + std::to_string(tested.param.which); });

// Catches a new effect without a row above: no test would check it.
TEST(Columns, EachIsInTheTable) {
  std::size_t columns = 0;
  for (const TranslationEffect& effect : kTranslationEffects) {
    columns += effect.columns;
    EXPECT_EQ(effect.columns > 0, effect.column != nullptr) << effect.name;
  }
  EXPECT_EQ(columns, 15U);
  EXPECT_EQ(translation_effect("no such effect"), nullptr);
}

/// A series at 100 Hz with its own working space.
struct Series {
  std::vector<double> thrust, x, y, z, spare;
  explicit Series(const std::vector<double>& values)
      : thrust(values), x(values), y(values.size(), 1.0), z(values.size(), 0.0), spare(values.size()) {}
  void reshape(const std::string& effect, double searched) {
    translation_effect(effect)->reshape(
        {.period_s = 0.01, .thrust_m_s2 = thrust, .direction_w = {x, y, z}, .spare = spare}, searched);
  }
};

TEST(ThrustLag, FollowsAStepAsTheExponentialSays) {
  Series series(std::vector<double>(101, 1.0));
  series.thrust[0] = 0.0;
  series.reshape("thrust_lag", 0.2);
  const double share = 1.0 - std::exp(-0.05);
  EXPECT_NEAR(series.thrust[1], 0.5 * share, 1e-12) << "half of the first period is before the step";
  for (std::size_t i = 2; i < series.thrust.size(); ++i) {
    EXPECT_NEAR(series.thrust[i], 1.0 - (1.0 - 0.5 * share) * std::exp(-0.05 * static_cast<double>(i - 1)), 1e-12) << i;
  }
  Series untouched({1.0, 2.0, 5.0});
  untouched.reshape("thrust_lag", 0.0);
  EXPECT_EQ(untouched.thrust, (std::vector{1.0, 2.0, 5.0}));
  Series nothing({});
  nothing.reshape("thrust_lag", 0.1);
  EXPECT_TRUE(nothing.thrust.empty());
}

TEST(TimeOffset, TakesThrustAndAttitudeEarlierBetweenTheSamplesAndHoldsTheEnds) {
  Series late({0.0, 10.0, 20.0, 30.0, 50.0});
  late.reshape("time_offset", 0.015);  // 1.5 samples
  const std::vector<double> expected{0.0, 0.0, 5.0, 15.0, 25.0};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(late.thrust[i], expected[i], 1e-6) << i;
    EXPECT_NEAR(late.x[i], expected[i], 1e-6) << i;
    EXPECT_EQ(late.y[i], 1.0);
  }
  Series early({0.0, 10.0, 20.0});
  early.reshape("time_offset", -0.01);
  EXPECT_NEAR(early.thrust[0], 10.0, 1e-6);
  EXPECT_NEAR(early.thrust[2], 20.0, 1e-6);
  for (const auto& [values, offset_s] : {std::pair{std::vector{1.0, 2.0}, 0.0}, std::pair{std::vector{7.0}, 0.1}}) {
    Series untouched(values);
    untouched.reshape("time_offset", offset_s);
    EXPECT_EQ(untouched.thrust, values) << "no offset, or no second sample to take";
  }
}

TEST(YawMisalignment, TurnsTheThrustAboutTheVerticalToTheLeft) {
  Series series({2.0, 2.0});
  series.reshape("yaw_misalignment", 0.5 * std::numbers::pi);
  EXPECT_NEAR(series.x[1], -1.0, 1e-12);
  EXPECT_NEAR(series.y[1], 2.0, 1e-12);
  EXPECT_EQ(series.z[1], 0.0);
  Series untouched({2.0});
  untouched.reshape("yaw_misalignment", 0.0);
  EXPECT_EQ(untouched.x[0], 2.0);
}

/// The reported numbers, from the searched and the linear parameters.
TEST(Reports, SayTheNumbersOfTheirParameters) {
  const auto reported = [](const char* name, std::vector<double> searched, std::vector<double> linear) {
    std::vector<double> out(3, -7.0);
    translation_effect(name)->report(searched, linear, out);
    return out;
  };
  EXPECT_EQ(reported("tilt_gain", {}, {-0.25})[0], 0.75);
  EXPECT_EQ(reported("thrust_lag", {0.125}, {})[0], 0.125);
  EXPECT_EQ(reported("periodic_wind", {0.5}, {3.0, -4.0, 5.0, 12.0}), (std::vector{0.5, 5.0, 13.0}));
  const auto size = [](const char* name, std::vector<double> numbers) {
    return translation_effect(name)->size(numbers);
  };
  EXPECT_EQ(size("linear_drag", {-0.5}), -0.5) << "a drag that pushes has no size";
  EXPECT_EQ(size("steady_wind", {3.0, -4.0}), 5.0);
  EXPECT_EQ(size("periodic_wind", {0.5, 5.0, 12.0}), 13.0) << "the frequency is no size";
  EXPECT_EQ(size("time_offset", {-0.25}), 0.25);
  EXPECT_EQ(size("time_offset", {0.25}), 0.25);
  EXPECT_EQ(size("tilt_gain", {0.75}), 0.25);
  EXPECT_EQ(size("tilt_gain", {1.25}), 0.25);
}

// The simulated air: drags add up, each times its number and the mass ratio. Effects that act on the thrust do not
// count.
TEST(OuterAcceleration, IsTheSumOfTheForcesThatTheNumbersDescribe) {
  Translation numbers;
  numbers.linear_drag_per_s = 0.5;
  numbers.quadratic_drag_per_m = 0.1;
  numbers.body_drag_y_per_s = 2.0;
  numbers.thrust_gain = 1.5;
  const Acceleration seen = outer_acceleration(numbers, turned_left(), 0.5);
  EXPECT_NEAR(seen[0], 0.5 * (-1.5 - 3.9 - 6.0), 1e-12);
  EXPECT_NEAR(seen[1], 0.5 * (-2.0 - 5.2), 1e-12);
  EXPECT_NEAR(seen[2], 0.5 * (6.0 + 15.6), 1e-12);
  EXPECT_TRUE(simulated("linear_drag_per_s"));
  EXPECT_FALSE(simulated("thrust_gain")) << "it changes the thrust itself";
  EXPECT_FALSE(simulated("mass_kg")) << "it is no effect's";
}

TEST(Translation, WithOneNumberChangedKeepsTheOthers) {
  for (const auto& number : kTranslationNumbers) {
    const Translation changed = Translation{}.with(number.key, 0.125);
    for (const auto& other : kTranslationNumbers) {
      EXPECT_EQ(changed.*other.member, other.key == number.key ? 0.125 : Translation{}.*other.member) << number.key;
    }
  }
}

}  // namespace
}  // namespace m100::model
