// SPDX-License-Identifier: BSD-3-Clause
// 32-bit fixed-point arithmetic: every operation gives the number computed by hand, also where it rounds and at the
// ends of its range.
#include "firmware/core/fixed_point.h"

#include <gtest/gtest.h>

namespace m100::core {
namespace {

using Q = Arithmetic<Fixed>;
constexpr std::int32_t kOne = 1 << 24;
constexpr std::int32_t kMax = 0x7FFFFFFF;

TEST(FixedPoint, NumbersAreRoundedToTheNearestStepAndStopAtTheEnds) {
  EXPECT_EQ(Fixed().raw(), 0);
  EXPECT_EQ(Q::number(1.0).raw(), kOne);
  EXPECT_EQ(Q::number(-2.5).raw(), -5 * kOne / 2);
  const double step = 1.0 / kOne;
  EXPECT_EQ(Q::number(0.4 * step).raw(), 0);
  EXPECT_EQ(Q::number(0.6 * step).raw(), 1);
  EXPECT_EQ(Q::number(-0.6 * step).raw(), -1);
  EXPECT_EQ(Q::number(-0.4 * step).raw(), 0);
  EXPECT_EQ(Q::number(127.5).raw(), 255 * (kOne / 2));
  for (const double large : {128.0, 1e9}) {
    EXPECT_EQ(Q::number(large).raw(), Q::number(127.99999).raw());
    EXPECT_EQ(Q::number(-large).raw(), -Q::number(127.99999).raw());
  }
  EXPECT_EQ(Q::real<double>(Fixed::from_raw(3)), 3.0 * step);
  EXPECT_EQ(Q::real<float>(Q::number(-7.25F)), -7.25F);
  EXPECT_LT(Fixed::from_raw(-1), Fixed::from_raw(1));
}

TEST(FixedPoint, SumsOfProductsAreRoundedOnce) {
  Q q;
  EXPECT_EQ(q.narrow(Q::widen(Q::number(3.75))), Q::number(3.75));
  EXPECT_EQ(q.narrow(Q::product(Q::number(-1.5), Q::number(2.5))), Q::number(-3.75));
  EXPECT_EQ(q.narrow(Q::widen(Q::number(1.0)) + Q::product(Q::number(0.5), Q::number(0.5))), Q::number(1.25));
  const Q::Wide half_step = Q::Wide{1} << 23;
  EXPECT_EQ(q.narrow(half_step - 1).raw(), 0);
  EXPECT_EQ(q.narrow(half_step).raw(), 1) << "half a step goes up";
  EXPECT_EQ(q.narrow(-half_step).raw(), 0);
  EXPECT_EQ(q.narrow(-half_step - 1).raw(), -1);
  EXPECT_EQ(q.saturations(), 0U);
}

TEST(FixedPoint, PowersOfTwoAreShifts) {
  EXPECT_EQ(Q::scaled(5, 0), 5);
  EXPECT_EQ(Q::scaled(5, 3), 40);
  EXPECT_EQ(Q::scaled(-5, 3), -40);
  EXPECT_EQ(Q::scaled(40, -3), 5);
  EXPECT_EQ(Q::scaled(43, -3), 5);
  EXPECT_EQ(Q::scaled(44, -3), 6) << "half goes up";
  EXPECT_EQ(Q::scaled(-44, -3), -5);
  EXPECT_EQ(Q::scaled(-45, -3), -6);
  EXPECT_EQ(Q::scaled(1, -1), 1);
}

TEST(FixedPoint, WhatDoesNotFitStopsAtTheEndAndIsCounted) {
  Q q;
  EXPECT_EQ(q.narrow(Q::Wide{kMax} << 24).raw(), kMax);
  EXPECT_EQ(q.narrow(-(Q::Wide{kMax} << 24)).raw(), -kMax);
  EXPECT_EQ(q.saturations(), 0U);
  EXPECT_EQ(q.narrow(((Q::Wide{kMax} + 1) << 24)).raw(), kMax);
  EXPECT_EQ(q.narrow(-((Q::Wide{kMax} + 1) << 24)).raw(), -kMax) << "the ends are as far from zero";
  EXPECT_EQ(q.saturations(), 2U);
  EXPECT_EQ(q.quotient(Q::number(100.0), Q::number(0.5)).raw(), kMax);
  EXPECT_EQ(q.saturations(), 3U);
}

TEST(FixedPoint, AQuotientIsThatOfTheNumbers) {
  Q q;
  EXPECT_EQ(q.quotient(Q::number(3.0), Q::number(-1.0)).raw(), kMax) << "of a denominator that is none";
  EXPECT_EQ(q.quotient(Q::number(1.0), Q::number(4.0)), Q::number(0.25));
  EXPECT_EQ(q.quotient(Q::number(-9.0), Q::number(2.0)), Q::number(-4.5));
  EXPECT_EQ(q.quotient(Fixed::from_raw(1), Fixed::from_raw(1)), Q::number(1.0));
}

template <typename T>
class FloatArithmetic : public ::testing::Test {};
using Floats = ::testing::Types<float, double>;
TYPED_TEST_SUITE(FloatArithmetic, Floats);

TYPED_TEST(FloatArithmetic, IsTheProcessors) {
  using A = Arithmetic<TypeParam>;
  A a;
  const TypeParam x = TypeParam(1.5), y = TypeParam(-0.25);
  EXPECT_EQ(A::number(2.5), TypeParam(2.5));
  EXPECT_EQ(A::template real<double>(x), 1.5);
  EXPECT_EQ(A::widen(x), x);
  EXPECT_EQ(A::product(x, y), TypeParam(-0.375));
  EXPECT_EQ(A::scaled(x, 4), TypeParam(24));
  EXPECT_EQ(A::scaled(x, -3), TypeParam(0.1875));
  EXPECT_EQ(A::scaled(x, 0), x);
  EXPECT_EQ(A::scaled(x, 60), x * TypeParam(std::int64_t{1} << 60));
  EXPECT_EQ(A::scaled(x, -60), x / TypeParam(std::int64_t{1} << 60));
  EXPECT_EQ(a.narrow(y), y);
  EXPECT_EQ(a.quotient(x, TypeParam(0.5)), TypeParam(3));
  EXPECT_EQ(a.saturations(), 0U);
}

}  // namespace
}  // namespace m100::core
