// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>

#include "firmware/ctl/design_scale.h"
#include "firmware/ctl/law/altitude_pid.h"
#include "firmware/ctl/law/flight_law.h"
#include "firmware/ctl/law/yaw_p.h"
#include "firmware/model/paper.h"

namespace m100::ctl {
namespace {

TEST(AltitudePid, StartsFromThePapersGains) {
  RecordProperty("paper", "III-E.2");
  const model::AltitudeGains gains;
  EXPECT_EQ(gains.proportional_per_s, model::paper::kAltitudeKp);
  EXPECT_EQ(gains.integral_per_s2, model::paper::kAltitudeKi);
  EXPECT_EQ(gains.derivative, model::paper::kAltitudeKd);
  EXPECT_EQ(gains.integral_max_m_s, model::paper::kAltitudeIntegralLimit);
  AltitudePid<double> pid(gains);
  EXPECT_NEAR(pid.update({.height_m = 1.0}, 0.9, 0.0, 0.01), 1.963 * 0.1 + 6.190 * 0.1 * 0.01, 1e-12);
}

TEST(AltitudePid, TheIntegralKeepsItsLimits) {
  const model::AltitudeGains gains{.integral_min_m_s = -0.3};
  for (const auto& [sign, limit_m_s] : {std::pair{1.0, 0.2}, {-1.0, -0.3}}) {
    AltitudePid<double> pid{gains};
    for (int i = 0; i < 1000; ++i) {
      pid.update({.height_m = 1.0 + sign * 0.1}, 1.0, 0.0, 0.01);
    }
    EXPECT_NEAR(pid.integral_m_s(), limit_m_s, 1e-12);
    EXPECT_NEAR(pid.update({.height_m = 0.9}, 0.9, 0.0, 0.01), limit_m_s, 1e-12);
    pid.reset();
    EXPECT_EQ(pid.integral_m_s(), 0.0);
  }
}

// Catches wind-up: while the output is at its limit the integral must not grow.
TEST(AltitudePid, StandsStillWhileTheOutputIsAtItsLimit) {
  for (const double sign : {1.0, -1.0}) {
    AltitudePid<double> pid{model::AltitudeGains{}};
    for (int i = 0; i < 1000; ++i) {
      EXPECT_EQ(pid.update({.height_m = sign * 10.0}, 0.0, 0.0, 0.01), sign * 2.0);
    }
    EXPECT_EQ(pid.integral_m_s(), 0.0);
    pid.update({.height_m = -sign * 0.1, .climb_command_m_s = sign * 3.0}, 0.0, 0.0, 0.01);
    EXPECT_NEAR(pid.integral_m_s(), -sign * 6.190 * 0.1 * 0.01, 1e-12) << "an error that leads away from the limit";
  }
}

// Catches a derivative of the error: a step of the reference must not cause a derivative kick; and a feed-forward that
// also passes the derivative, which would count the lag 1 + Kd times.
TEST(AltitudePid, DampsTheMeasuredClimbSpeedOnly) {
  model::AltitudeGains gains;
  gains.integral_per_s2 = 0.0;
  AltitudePid<double> pid(gains);
  EXPECT_NEAR(pid.update({.height_m = 1.1}, 1.0, 0.0, 0.01), 1.963 * 0.1, 1e-12);
  EXPECT_NEAR(pid.update({.height_m = 1.1}, 1.0, 0.5, 0.01), 1.963 * 0.1 - 0.156 * 0.5, 1e-12);
  EXPECT_NEAR(pid.update({.height_m = 1.1, .climb_m_s = 0.7, .climb_command_m_s = 0.9}, 1.0, 0.5, 0.01),
              0.9 + 1.963 * 0.1 + 0.156 * 0.2, 1e-12);
}

model::StickAxis first_order(double time_constant_s, double delay_s) {
  model::StickAxis axis;
  axis.time_constant_s = time_constant_s;
  axis.transport_delay_s = delay_s;
  return axis;
}
model::StickAxis second_order(double frequency_rad_s, double damping, double delay_s) {
  model::StickAxis axis;
  axis.natural_frequency_rad_s = frequency_rad_s;
  axis.damping_ratio = damping;
  axis.transport_delay_s = delay_s;
  return axis;
}
// Worked out by hand from the header: frequency w = 0.41 / d, d = delay + rest of the lag + 30 ms, at most 4 rad/s
// and (1/T + 0.6 / (d + 20 ms)) / 2.1; then Kp = w^2 T, Kd = 2.1 w T - 1 (damping 1.05), or, where T damps enough by
// itself, no derivative and Kp = the lesser of 1/(4.41 T) and 0.45 / (d + 20 ms).
TEST(DesignOfTheAltitudeLoop, GivesTheGainsOfItsEquations) {
  struct Case {
    model::StickAxis climb;
    double proportional_per_s, derivative, integral_per_s2;
  };
  for (const Case& one : {Case{first_order(0.5, 0.02), 8.0, 3.2, 2.56},                  // w = 8.2, cut to 4
                          Case{first_order(0.334, 0.08), 4.3854, 1.5415, 1.2712},        // as flown: w = 3.6235
                          Case{first_order(0.334, 0.17), 1.4036, 0.4379, 0.2302},        // w = 2.05
                          Case{first_order(0.6, 0.97), 0.3779, 0.0, 0.0124},             // w = 0.41
                          Case{first_order(0.05, 0.17), 2.0455, 0.0, 0.3355},            // 0.45 / 0.22
                          Case{second_order(3.0, 0.7, 0.1), 0.8913, 0.3544, 0.0985}}) {  // T = 0.4667, w = 1.3820
    const model::AltitudeGains gains = design_altitude(one.climb, model::AltitudeGains{});
    EXPECT_NEAR(gains.proportional_per_s, one.proportional_per_s, 1e-3);
    EXPECT_NEAR(gains.derivative, one.derivative, 1e-3);
    EXPECT_NEAR(gains.integral_per_s2, one.integral_per_s2, 1e-3) << "0.08 w Kp";
    EXPECT_EQ(gains.integral_max_m_s, model::AltitudeGains{}.integral_max_m_s);
  }
}

// Worked out by hand: (1 + 0.2 s + 0.04 s^2) / (1 + 0.05 s) = 1 + 0.15 s + (0.04 - 0.05 * 0.15) s^2 + ...; catches a
// second-order term that ignores the lead zero.
TEST(InverseLags, DivideByTheLeadZero) {
  model::StickAxis axis = second_order(5.0, 0.5, 0.03);
  EXPECT_NEAR(inverse_lags(axis).first_s, 0.2, 1e-12);
  EXPECT_NEAR(inverse_lags(axis).second_s2, 0.04, 1e-12);
  axis.lead_zero_s = 0.05;
  EXPECT_EQ(inverse_lags(model::StickAxis{}).first_s, 0.0) << "of an axis that is not identified, nothing is inverted";
  EXPECT_EQ(inverse_lags(model::StickAxis{}).second_s2, 0.0);
  EXPECT_NEAR(inverse_lags(axis).first_s, 0.15, 1e-12);
  EXPECT_NEAR(inverse_lags(axis).second_s2, 0.0325, 1e-12);
  axis = first_order(0.3, 0.03);
  axis.lead_zero_s = 0.1;  // (1 + 0.3 s) / (1 + 0.1 s) = 1 + 0.2 s - 0.02 s^2 + ...
  EXPECT_NEAR(inverse_lags(axis).first_s, 0.2, 1e-12);
  EXPECT_NEAR(inverse_lags(axis).second_s2, -0.02, 1e-12);
}

// A design's scale of 5 % more in roll and 10 % less in pitch; climb and yaw rate have none.
TEST(DesignScale, ConvertsEachTiltByItsOwnAxis) {
  model::Vehicle vehicle;
  vehicle.roll.scale_per_count = vehicle.pitch.scale_per_count = 1e-3;
  vehicle.design.roll.scale_per_count = 1.05e-3;
  vehicle.design.pitch.scale_per_count = 0.9e-3;
  const Command<double> command{.roll_rad = 0.1, .pitch_rad = 0.2, .climb_m_s = 0.3, .yaw_rate_rad_s = 0.4};
  const auto numbers = [](const Command<double>& c) {
    return std::array{c.roll_rad, c.pitch_rad, c.climb_m_s, c.yaw_rate_rad_s};
  };
  const DesignScale<double> scale(vehicle, true);
  EXPECT_EQ(numbers(scale.expected(command)), (std::array{0.1 * (1.05e-3 / 1e-3), 0.2 * (0.9e-3 / 1e-3), 0.3, 0.4}));
  EXPECT_EQ(numbers(scale.to_send(command)), (std::array{0.1 / (1.05e-3 / 1e-3), 0.2 / (0.9e-3 / 1e-3), 0.3, 0.4}));
  EXPECT_EQ(numbers(DesignScale<double>(vehicle, false).expected(command)), numbers(command)) << "no sticks";
  vehicle.design.roll.scale_per_count = 0.0;
  vehicle.pitch.scale_per_count = 0.0;
  EXPECT_EQ(numbers(DesignScale<double>(vehicle, true).to_send(command)), numbers(command)) << "a scale is unknown";
}

// Catches a turn that takes the long way round.
TEST(YawTurns, GoTheShortWay) {
  struct Case {
    double wanted_rad, wanted_rate_rad_s, yaw_rad, rate_rad_s;
  };
  const YawP<double> yaw(model::YawGain{.proportional_per_s = 1.5, .rate_limit_rad_s = 1.0});
  for (const Case& one : {Case{0.1, 0.2, 0.0, 0.35}, Case{-0.1, 0.0, 0.0, -0.15}, Case{3.0, 0.2, 0.0, 1.0},
                          Case{-3.1, 0.0, 3.1, 1.5 * (2 * core::kPi - 6.2)},
                          Case{3.1, -0.2, -3.1, -0.2 - 1.5 * (2 * core::kPi - 6.2)}, Case{-3.0, 0.2, 0.0, -1.0}}) {
    EXPECT_NEAR(yaw.update(one.wanted_rad, one.wanted_rate_rad_s, one.yaw_rad), one.rate_rad_s, 1e-9);
  }
}

}  // namespace
}  // namespace m100::ctl
