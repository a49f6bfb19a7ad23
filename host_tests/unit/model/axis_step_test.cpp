// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/model/axis_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "firmware/model/exponential.h"

namespace m100::model {
namespace {

using Square2 = SquareMatrix<double, 2>;

/// e^(M h) of M = [0 1; -w^2 -2zw] in closed form, z != 1: with f = e^(-zwh) sin(v h) / v and g = e^(-zwh) cos(v h),
/// v = w sqrt(1 - z^2), above z = 1 with the hyperbolic functions.
Square2 closed_form(double w, double z, double h) {
  const double v = w * std::sqrt(std::abs(1.0 - z * z));
  // The hyperbolic functions are differences of exponentials here, so that no large number is multiplied by a small
  // one.
  const double fast = std::exp(-(z * w + v) * h), slow = std::exp(-(z * w - v) * h);
  const double f = z < 1.0 ? std::exp(-z * w * h) * std::sin(v * h) / v : (slow - fast) / (2.0 * v);
  const double g = z < 1.0 ? std::exp(-z * w * h) * std::cos(v * h) : (slow + fast) / 2.0;
  return {g + z * w * f, f, -w * w * f, g - z * w * f};
}

// Catches a series that is too short, a halving that is not squared back, and factors in the wrong order, over the
// whole range of axes. Each halving doubles the rounding error: 2^-52 times the row sum and some operations.
TEST(Exponential, AgreesWithTheClosedForm) {
  for (const double w : {0.5, 3.0, 7.2, 20.0, 50.0}) {
    for (const double z : {0.0, 0.3, 0.7, 0.99, 1.01, 2.0, 5.0}) {
      for (const double h : {0.001, 0.01, 0.05, 0.1}) {
        const Square2 matrix{0.0, h, -w * w * h, -2.0 * z * w * h};
        const Square2 exact = closed_form(w, z, h);
        const Square2 found = exponential<2>(matrix);
        const double size = std::max(1.0, row_sum_norm<2>(matrix));
        for (std::size_t i = 0; i < found.size(); ++i) {
          EXPECT_NEAR(found.at(i), exact.at(i), 0x1p-52 * 16.0 * size * std::max(1.0, row_sum_norm<2>(exact)))
              << "entry " << i << ", w " << w << ", z " << z << ", step " << h;
        }
      }
    }
  }
}

// The tables of the MPC are computed with more digits than double. e^[0 1; 0 0] shows a missing term, e^1 the number of
// digits.
TEST(Exponential, HasTheDigitsOfItsNumbers) {
  const auto e = exponential<1>(SquareMatrix<long double, 1>{1.0L});
  EXPECT_NEAR(static_cast<double>((e[0] - std::exp(1.0L)) / std::exp(1.0L)), 0.0,
              4.0 * std::max(static_cast<double>(std::numeric_limits<long double>::epsilon()), 0x1p-63));
  const auto nilpotent = exponential<2>(Square2{0.0, 3.0, 0.0, 0.0});
  EXPECT_EQ(nilpotent, (Square2{1.0, 3.0, 0.0, 1.0}));
}

// Catches a command that is held on the wrong side of the step, and a jump of the lead zero that is lost or doubled.
// The reference integration is of second order with steps of 1e-7 s: its error is far below the tolerance.
TEST(AxisStep, AgreesWithFineIntegrationOfTheLawWithItsZero) {
  for (const double zero_s : {0.0, 0.05}) {
    const StickAxis law{.natural_frequency_rad_s = 8.69, .damping_ratio = 0.682, .lead_zero_s = zero_s};
    const AxisStep step = axis_step(law, 0.01);
    const double w = law.natural_frequency_rad_s;
    double a = 0.02, r = -0.1;
    const double u = 0.1, before = 0.05;
    const double coarse = step.oo * a + step.o_r * r + step.o_u * u + step.o_jump * (u - before);
    const double coarse_rate = step.ro * a + step.rr * r + step.r_u * u + step.r_jump * (u - before);
    r += w * w * zero_s * (u - before);
    for (int i = 0; i < 100000; ++i) {
      const double h = 1e-7;
      const double acceleration = w * w * (u - a) - 2.0 * law.damping_ratio * w * r;
      a += h * r + 0.5 * h * h * acceleration;
      r += h * acceleration;
    }
    EXPECT_NEAR(coarse, a, 1e-8);
    EXPECT_NEAR(coarse_rate, r, 1e-6);
  }
}

TEST(AxisStep, FirstOrderRateIsItsRightSide) {
  const AxisStep step = axis_step({.time_constant_s = 0.087}, 0.01);
  const double a = 0.1, u = 0.3, next = 0.4;
  const double after = step.oo * a + step.o_u * u;
  EXPECT_NEAR(after, u + (a - u) * std::exp(-0.01 / 0.087), 1e-12);
  EXPECT_NEAR(step.ro * a + step.r_u * u + step.r_next * next, (next - after) / 0.087, 1e-12);
}

TEST(AxisStep, AnAxisWithoutDynamicsFollowsAtOnce) {
  const AxisStep step = axis_step({}, 0.01);
  EXPECT_EQ(step.oo * 0.3 + step.o_r * 2.0 + step.o_u * 0.1 + step.o_jump * 0.5, 0.1);
}

}  // namespace
}  // namespace m100::model
