// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/maths.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

namespace m100::core {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Would catch: a conversion of a huge number to an integer (undefined behaviour), and a NaN whose bits depend on the
// machine.
TEST(Maths, AnswersBadArgumentsWithOneNan) {
  for (const double bad : {kNan, -kNan, kInfinity, -kInfinity, 1.0001e5, -1e300}) {
    for (const double answer : {sin(bad), cos(bad), tan(bad), wrap_pi(bad)}) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(answer), 0x7ff8000000000000U) << bad;
    }
  }
  for (const double bad : {kNan, -kNan}) {
    for (const double answer : {asin(bad), exp(bad), atan2(bad, 1.0), atan2(1.0, bad)}) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(answer), 0x7ff8000000000000U) << bad;
    }
  }
  EXPECT_EQ(std::bit_cast<std::uint32_t>(sin(std::numeric_limits<float>::infinity())), 0x7fc00000U);
}

// sin and cos must equal sin_cos_of to the last bit, so their measured accuracy holds for sin_cos_of too.
TEST(Maths, TurnsAreSineAndCosineToTheLastBit) {
  for (int i = -4000; i <= 4000; ++i) {
    const double angle_rad = 0.00123 * i * (1.0 + 0.01 * (i % 7));
    const SinCos<double> turn = sin_cos_of(angle_rad);
    ASSERT_EQ(turn.sine, sin(angle_rad)) << angle_rad;
    ASSERT_EQ(turn.cosine, cos(angle_rad)) << angle_rad;
    const auto narrow_rad = static_cast<float>(angle_rad);
    ASSERT_EQ(sin_cos_of(narrow_rad).sine, sin(narrow_rad)) << angle_rad;
    ASSERT_EQ(sin_cos_of(narrow_rad).cosine, cos(narrow_rad)) << angle_rad;
  }
  EXPECT_TRUE(sin_cos_of(2.0 * kLargestAngle_rad).sine != sin_cos_of(2.0 * kLargestAngle_rad).sine);
}

TEST(Maths, ClampsWhereItSaysSo) {
  EXPECT_EQ(asin(1.5), asin(1.0));
  EXPECT_EQ(asin(-kInfinity), asin(-1.0));
  EXPECT_EQ(exp(kInfinity), exp(80.0));
  EXPECT_EQ(exp(-1e9), exp(-80.0));
  EXPECT_EQ(sqrt(-1.0), 0.0);
}

struct Direction {
  const char* name;
  double y;
  double x;
  double angle_rad;
};

class ArcTangentOf : public ::testing::TestWithParam<Direction> {};

// Exact answers: the corners of the octants, every sign, and lengths whose squares and products exceed the range of
// double.
TEST_P(ArcTangentOf, IsExact) { EXPECT_EQ(atan2(GetParam().y, GetParam().x), GetParam().angle_rad); }

INSTANTIATE_TEST_SUITE_P(Directions, ArcTangentOf,
                         ::testing::Values(Direction{"Nothing", 0.0, 0.0, 0.0}, Direction{"Right", 0.0, 2.0, 0.0},
                                           Direction{"Left", 0.0, -2.0, kPi},
                                           Direction{"LeftFromBelow", -0.0, -2.0, kPi},
                                           Direction{"Up", 3.0, 0.0, kPi / 2}, Direction{"Down", -3.0, 0.0, -kPi / 2},
                                           Direction{"FirstDiagonal", 5.0, 5.0, kPi / 4},
                                           Direction{"SecondDiagonal", 5.0, -5.0, 3 * kPi / 4},
                                           Direction{"ThirdDiagonal", -5.0, -5.0, -3 * kPi / 4},
                                           Direction{"FourthDiagonal", -5.0, 5.0, -kPi / 4},
                                           Direction{"HugeDiagonal", 1.7e308, 1.7e308, kPi / 4},
                                           Direction{"TinyDiagonal", 5e-324, 5e-324, kPi / 4},
                                           Direction{"Flat", 1e-300, 1e300, 0.0},
                                           Direction{"SmallButNotNothing", 1e-300, 2.0, 5e-301}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(WrapPi, LeavesAnglesInsideAlone) {
  for (const float angle_rad : {0.F, -3.1F, 3.14159274F, 1e-30F}) {
    EXPECT_EQ(wrap_pi(angle_rad), angle_rad);
  }
  EXPECT_EQ(wrap_pi(-kPi), kPi);
  EXPECT_GT(wrap_pi(-static_cast<float>(kPi)), 0.F);  // -pi as float lies below -pi, so it wraps to +pi
}

// Catches a half turn that becomes -pi, which is outside the range of angles. The test tries odd half turns in float;
// rounding puts some on each side of the limit.
TEST(WrapPi, NeverIsMinusPi) {
  const auto half_turn = static_cast<float>(kPi);
  for (int half_turns = -201; half_turns <= 201; half_turns += 2) {
    auto angle_rad = static_cast<float>(half_turns * kPi);
    for (int step = 0; step < 3; ++step, angle_rad = std::nextafter(angle_rad, 1e9F)) {
      EXPECT_GT(wrap_pi(angle_rad), -half_turn) << angle_rad;
      EXPECT_LE(wrap_pi(angle_rad), half_turn) << angle_rad;
    }
  }
  EXPECT_EQ(wrap_pi(-0x1.2d97c8p+3F), half_turn) << "-3 pi, one and a half turns";
}

TEST(WrapPi, TakesWholeTurnsOff) {
  EXPECT_NEAR(wrap_pi(3.0 + 2 * kPi), 3.0, 1e-15);     // 2 pi rounded costs 2.4e-16, the sum 4e-16
  EXPECT_NEAR(wrap_pi(-3.0 - 20 * kPi), -3.0, 1e-14);  // ten times that
  EXPECT_NEAR(wrap_pi(kPi + 0.25), 0.25 - kPi, 1e-15);
}

}  // namespace
}  // namespace m100::core
