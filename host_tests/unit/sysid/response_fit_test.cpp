// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/sysid/response_fit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace m100::sysid {
namespace {

constexpr double kSample_s = 0.01;

/// Adds one block of an oscillation about `offset`, whose error has both causes. @returns whether the fit has the three
/// blocks that it needs.
bool add_block(ResponseFit<double>& fit, double gain, double late_s, double offset) {
  fit.begin();
  for (int k = 0; k < 250; ++k) {
    const double t_s = k * kSample_s;
    const double predicted = offset + 0.2 * std::sin(4.0 * t_s);
    const double slope = 0.8 * std::cos(4.0 * t_s);
    fit.add(predicted, slope, -gain * (predicted - offset) + late_s * slope + 3.0 * offset);
  }
  return fit.end();
}

// Catches a wrong sign, a share that is counted twice, and an offset that is taken for a gain; the model is exact here.
TEST(ResponseFit, FindsGainAndTimeOfAnExactResponse) {
  ResponseFit<double> fit(kSample_s);
  EXPECT_FALSE(add_block(fit, 0.25, -0.03, 0.5));
  EXPECT_FALSE(add_block(fit, 0.25, -0.03, -0.5));
  ASSERT_TRUE(add_block(fit, 0.25, -0.03, 2.0));
  EXPECT_NEAR(fit.report().gain, 0.25, 1e-9);
  EXPECT_NEAR(fit.report().late_s, -0.03, 1e-9);
  EXPECT_NEAR(fit.report().gain_sigma, 0.0, 1e-5);
  EXPECT_NEAR(fit.report().swing, 0.2 / std::sqrt(2.0), 0.01) << "of a sine";
}

// Catches a gain that is divided by zero: a constant prediction, and one that is proportional to its slope.
TEST(ResponseFit, SaysNothingOfAPredictionThatCannotTell) {
  for (const double copied : {0.0, 2.0}) {
    ResponseFit<double> fit(kSample_s);
    for (int block = 0; block < 4; ++block) {
      ASSERT_EQ(add_block(fit, 0.25, 0.0, 0.0), block >= 2);
    }
    ASSERT_NE(fit.report().gain, 0.0);
    for (int block = 0; block < 3; ++block) {
      fit.begin();
      for (int k = 0; k < 250; ++k) {
        const double moved = copied > 0.0 ? std::sin(0.04 * k) : 0.0;
        fit.add(0.3 + moved, copied * moved, std::cos(0.1 * k));
      }
      ASSERT_TRUE(fit.end());
    }
    EXPECT_EQ(fit.report().gain, 0.0) << "nor what it said before";
    EXPECT_EQ(fit.report().gain_sigma, 0.0);
    EXPECT_EQ(fit.report().late_s, 0.0);
    EXPECT_EQ(fit.report().swing, 0.0);
  }
}

}  // namespace
}  // namespace m100::sysid
