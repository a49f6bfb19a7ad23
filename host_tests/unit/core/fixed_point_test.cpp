// SPDX-License-Identifier: BSD-3-Clause
// Fixed-point arithmetic of 64 bits: every operation gives the number computed by hand, also where it rounds and at the
// ends of its range.
#include "firmware/core/fixed_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "firmware/core/eigen.h"

namespace m100::core {
namespace {

constexpr std::int64_t kOne = std::int64_t{1} << Fixed::kFractionBits;
constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
constexpr Fixed kEnd = Fixed::from_raw(kMax);

TEST(FixedPoint, NumbersAreRoundedToTheNearestStepAndStopAtTheEnds) {
  EXPECT_EQ(Fixed().raw(), 0);
  EXPECT_EQ(Fixed(1).raw(), kOne);
  EXPECT_EQ(Fixed(-2.5).raw(), -5 * kOne / 2);
  constexpr double kStep = 1.0 / static_cast<double>(kOne);
  EXPECT_EQ(Fixed(0.4 * kStep).raw(), 0);
  EXPECT_EQ(Fixed(0.6 * kStep).raw(), 1);
  EXPECT_EQ(Fixed(-0.6 * kStep).raw(), -1);
  EXPECT_EQ(Fixed(-0.4 * kStep).raw(), 0);
  EXPECT_EQ(Fixed(524287.5).raw(), kOne / 2 * 1048575);
  for (const double large : {524288.0, 1e9, std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(Fixed(large), kEnd);
    EXPECT_EQ(Fixed(-large), -kEnd) << "the ends are as far from zero";
  }
  EXPECT_EQ(static_cast<double>(Fixed::from_raw(3)), 3.0 * kStep);
  EXPECT_EQ(static_cast<float>(Fixed(-7.25F)), -7.25F);
  EXPECT_LT(Fixed::from_raw(-1), Fixed::from_raw(1));
}

TEST(FixedPoint, WhatDoesNotFitStopsAtTheEnd) {
  const Fixed step = Fixed::from_raw(1), large(1000);
  EXPECT_EQ(kEnd + step, kEnd);
  EXPECT_EQ(-kEnd - step, -kEnd);
  EXPECT_EQ(-kEnd + kEnd, Fixed(0));
  EXPECT_EQ(large * large, kEnd);
  EXPECT_EQ(large * -large, -kEnd);
  EXPECT_EQ(kEnd * kEnd, kEnd);
  EXPECT_EQ(large / Fixed(1e-6), kEnd);
  EXPECT_EQ(-large / step, -kEnd);
  EXPECT_EQ(kEnd / Fixed(1), kEnd);
  EXPECT_EQ(Fixed(-1) / Fixed(0), -kEnd);
}

TEST(FixedPoint, AProductAndAQuotientAreRounded) {
  const auto raw = [](std::int64_t value) { return Fixed::from_raw(value); };
  EXPECT_EQ(Fixed(-1.5) * Fixed(2.5), Fixed(-3.75));
  EXPECT_EQ(raw(1) * Fixed(0.5), raw(1)) << "half a step goes away from zero";
  EXPECT_EQ(raw(-1) * Fixed(0.5), raw(-1));
  EXPECT_EQ(raw(1) * Fixed(0.499), raw(0));
  EXPECT_EQ(Fixed(1) / Fixed(4), Fixed(0.25));
  EXPECT_EQ(Fixed(-9) / Fixed(2), Fixed(-4.5));
  EXPECT_EQ(raw(2) / Fixed(3), raw(0));
  EXPECT_EQ(raw(1) / raw(1), Fixed(1));
}

// Catches a carry that is lost between the halves of a product, and a bit that is lost in the long division. The
// product of two numbers with 26 bits is exact in double.
TEST(FixedPoint, ProductsAndQuotientsOfRandomNumbersAreThoseOfTheNumbers) {
  std::mt19937 random(7);
  for (int i = 0; i < 100000; ++i) {
    const auto drawn = [&random] { return (static_cast<double>(random() >> 6U) - 0x1p25) * 0x1p-24; };
    const double x = drawn(), y = drawn();
    EXPECT_EQ(Fixed(x) * Fixed(y), Fixed(x * y)) << x << " * " << y;
    if (y * y > 1e-4) {
      EXPECT_NEAR(static_cast<double>(Fixed(x) / Fixed(y)), x / y, 1e-13 + 1e-15 * std::abs(x / y));
    }
  }
}

TEST(FixedPoint, StandsInAMatrix) {
  Matrix<Fixed, 2, 3> a;
  a << Fixed(1), Fixed(2), Fixed(3), Fixed(-4), Fixed(0.5), Fixed(0);
  const Matrix<Fixed, 2, 2> square = a * a.transpose();
  EXPECT_EQ(square(0, 0), Fixed(14));
  EXPECT_EQ(square(1, 0), Fixed(-3));
  EXPECT_EQ(square(1, 1), Fixed(16.25));
}

}  // namespace
}  // namespace m100::core
