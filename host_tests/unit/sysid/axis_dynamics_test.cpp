// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/sysid/axis_dynamics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace m100::sysid {
namespace {

constexpr double kPeriod_s = 0.01;

// Would catch Euler steps, and an input that is held on the wrong side of the sample: the result must equal the closed
// form of the step response.
TEST(AxisDynamics, SecondOrderStepIsExact) {
  model::StickAxis axis;
  axis.natural_frequency_rad_s = 8.69;
  axis.damping_ratio = 0.68;
  AxisDynamics<double> dynamics(axis, kPeriod_s);
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

// An overdamped, fast axis: the series of the matrix exponential must still converge at the limit of the permitted
// range.
TEST(AxisDynamics, OverdampedFastAxisSettlesAtTheCommand) {
  model::StickAxis axis;
  axis.natural_frequency_rad_s = 50.0;
  axis.damping_ratio = 4.0;
  AxisDynamics<double> dynamics(axis, kPeriod_s);
  dynamics.start(-0.3, 1.0);
  for (int k = 0; k < 400; ++k) {
    dynamics.step(0.2);
  }
  EXPECT_NEAR(dynamics.value(), 0.2, 1e-9);
  EXPECT_NEAR(dynamics.rate_per_s(), 0.0, 1e-8);
}

TEST(AxisDynamics, RateLimitHoldsInEveryStep) {
  model::StickAxis axis;
  axis.natural_frequency_rad_s = 9.0;
  axis.damping_ratio = 0.7;
  axis.rate_limit_per_s = 0.5;
  AxisDynamics<double> dynamics(axis, kPeriod_s);
  dynamics.start(0.0, 2.0);
  double before = 0.0;
  for (int k = 0; k < 200; ++k) {
    const double now = dynamics.step(k < 100 ? 0.4 : -0.4);
    EXPECT_LE(std::abs(now - before), 0.5 * kPeriod_s * (1.0 + 1e-12));
    before = now;
  }
}

// Catches a rate limit that only second-order axes keep. From rest a fast axis moves at its limit until it arrives.
TEST(AxisDynamics, FirstOrderKeepsItsRateLimitAndArrives) {
  model::StickAxis axis;
  axis.time_constant_s = 0.02;
  axis.rate_limit_per_s = 0.5;
  AxisDynamics<double> dynamics(axis, kPeriod_s);
  dynamics.start(0.0, 0.0);
  for (int k = 1; k <= 10; ++k) {
    EXPECT_NEAR(dynamics.step(-0.2), -0.005 * k, 1e-12) << "after " << k << " periods at -0.5 per second";
  }
  for (int k = 0; k < 100; ++k) {
    dynamics.step(-0.2);
  }
  EXPECT_NEAR(dynamics.value(), -0.2, 1e-9);
}

}  // namespace
}  // namespace m100::sysid
