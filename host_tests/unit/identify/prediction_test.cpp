// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/prediction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace m100::lab::identify {
namespace {

using Complex = std::complex<double>;
using logs::Signal;

constexpr double kTurn_rad_s = 0.5 * std::numbers::pi;  // of the stick's sine; a period is 40 starts, so the mean is 0
constexpr double kTau_s = 0.2;
constexpr double kTilt_rad = 0.05;  // commanded; small, so that the tangent is the angle within 0.1 %

/// An aircraft of first order, without drag, whose pitch stick moves in a sine: its attitude and position in closed
/// form.
logs::FlightLog swung() {
  logs::FlightLog log;
  log.size = 4400;
  const Complex turn(0.0, kTurn_rad_s), tilt = kTilt_rad / (1.0 + turn * kTau_s);
  for (const Signal still : {Signal::kStickRoll, Signal::kStickThrottle, Signal::kStickYaw, Signal::kAttitudeRoll,
                             Signal::kAttitudeYaw, Signal::kPositionY, Signal::kPositionZ}) {
    log.of(still).assign(log.size, 0.0);
  }
  for (std::size_t k = 0; k < log.size; ++k) {
    const Complex now = std::exp(turn * log.time_s(k));
    log.of(Signal::kStickPitch).push_back(100.0 * now.imag());
    log.of(Signal::kAttitudePitch).push_back((tilt * now).imag());
    log.of(Signal::kPositionX).push_back((model::kGravity_m_s2 * tilt * now / (turn * turn)).imag());
  }
  return log;
}

/// Root mean squares after a time, of the velocity and position by an aircraft that tilts half as far for a stick.
std::pair<double, double> errors_of_half_the_gain(double after_s) {
  const Complex turn(0.0, kTurn_rad_s), begun = (std::exp(turn * after_s) - 1.0) / turn;
  const double decayed_s = kTau_s * (1.0 - std::exp(-after_s / kTau_s));
  const Complex half = 0.5 * model::kGravity_m_s2 * kTilt_rad / (1.0 + turn * kTau_s) / std::numbers::sqrt2;
  return {std::abs(half * (begun - decayed_s)),
          std::abs(half * ((begun - after_s) / turn - kTau_s * (after_s - decayed_s)))};
}

// Catches a wrong sign, frame, start or horizon of the predicted motion, and a velocity that is not the position's.
TEST(MotionPrediction, HasTheErrorsOfAWrongGainInClosedForm) {
  const logs::FlightLog log = swung();
  const UnseenFlight flight{&log, {{1.0, 43.25}}};  // 400 starts
  model::Vehicle vehicle;
  vehicle.translation.linear_drag_per_s = 0.0;
  vehicle.roll = vehicle.climb = {.scale_per_count = 1e-3, .time_constant_s = kTau_s};
  vehicle.pitch = {.scale_per_count = 0.01 * kTilt_rad, .time_constant_s = kTau_s};
  const Prediction true_gain = predict_motion(vehicle, flight);
  vehicle.pitch.scale_per_count *= 0.5;
  const Prediction half_gain = predict_motion(vehicle, flight);
  for (std::size_t k = 0; k < kHorizons_s.size(); ++k) {
    const auto [velocity_m_s, position_m] = errors_of_half_the_gain(kHorizons_s[k]);
    // A stick that is held for a period acts half a period late: 0.8 % of a sine of this frequency, and a start that is
    // 5 ms later; position grows with the cube of the time.
    const double late = 0.008 + 3.0 * 0.005 / kHorizons_s[k];
    EXPECT_NEAR(half_gain.velocity_m_s[k], velocity_m_s, late * velocity_m_s) << kHorizons_s[k];
    EXPECT_NEAR(half_gain.position_m[k], position_m, late * position_m) << kHorizons_s[k];
    EXPECT_LT(true_gain.velocity_m_s[k], 2.0 * late * velocity_m_s) << kHorizons_s[k];
    EXPECT_LT(true_gain.position_m[k], 2.0 * late * position_m) << kHorizons_s[k];
  }
}

}  // namespace
}  // namespace m100::lab::identify
