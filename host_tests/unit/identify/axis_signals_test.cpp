// SPDX-License-Identifier: BSD-3-Clause
// A climb speed that was not logged is the derivative of the height.
#include "host_tests/lab/identify/data/axis_signals.h"

#include <gtest/gtest.h>

#include <cmath>

namespace m100::lab::identify {
namespace {

// Catches a derivative that smooths the response: the axis then looks slower than it is, by 1.2 % in its frequency.
TEST(Derivative, KeepsTheAmplitudeAndThePhaseOfAResponse) {
  constexpr double kPeriod_s = 0.01;
  for (const double rad_s : {2.0, 6.0, 10.0}) {
    std::vector<double> height(400);
    for (std::size_t i = 0; i < height.size(); ++i) {
      height[i] = std::sin(rad_s * kPeriod_s * static_cast<double>(i)) / rad_s;
    }
    const std::vector<double> speed = derivative(height, kPeriod_s);
    for (std::size_t i = 20; i < 380; ++i) {
      EXPECT_NEAR(speed[i], std::cos(rad_s * kPeriod_s * static_cast<double>(i)), 2e-3) << rad_s;
    }
  }
}

// Catches a window that ends outside of the series, and sums that do not belong to the window.
TEST(Derivative, OfALineIsItsSlopeUpToBothEnds) {
  constexpr double kPeriod_s = 0.01;
  std::vector<double> line(60);
  for (std::size_t i = 0; i < line.size(); ++i) {
    line[i] = 0.3 * kPeriod_s * static_cast<double>(i) - 5.0;
  }
  for (const double slope : derivative(line, kPeriod_s)) {
    EXPECT_NEAR(slope, 0.3, 1e-9);
  }
  EXPECT_EQ(derivative({1.0}, kPeriod_s).front(), 0.0);
}

}  // namespace
}  // namespace m100::lab::identify
