// SPDX-License-Identifier: BSD-3-Clause
// A value that is NaN, infinite or far too large reaches a check once. It must not stay in the check's sums, where it
// would agree with everything for good (promises R11 and R14).
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "firmware/est/consistency/attitude_rate_consistency.h"
#include "firmware/est/consistency/command_consistency.h"
#include "firmware/est/consistency/dead_reckoning.h"
#include "firmware/est/consistency/path_consistency.h"
#include "firmware/est/consistency/velocity_consistency.h"
#include "firmware/est/estimate.h"
#include "firmware/est/filter/disturbance_ekf.h"
#include "host_tests/unit/est/observed_vehicle.h"

namespace m100::est {
namespace {

// A fresh estimate, before any measurement: no field of it may permit a flight.
TEST(Estimate, AFreshOneIsWorthNothing) {
  const Estimate<double> fresh;
  EXPECT_FALSE(fresh.healthy);
  EXPECT_FALSE(fresh.prediction_valid);
  for (const AxisEstimate<double>& axis : {fresh.x, fresh.y}) {
    for (const double value : {axis.position_m, axis.velocity_m_s, axis.tilt_rad, axis.tilt_rate_rad_s,
                               axis.disturbance_m_s2, axis.input_offset_rad, axis.position_variance_m2,
                               axis.filter_variance_m2, axis.position_velocity_m2_s, axis.velocity_variance_m2_s2}) {
      EXPECT_EQ(value, 0.0);
    }
  }
  for (const double value :
       {fresh.height_m, fresh.climb_m_s, fresh.climb_offset_m_s, fresh.yaw_rad, fresh.yaw_rate_rad_s,
        fresh.refusal.distance_m, fresh.refusal.allowed_m, fresh.refusal.turned_rad}) {
    EXPECT_EQ(value, 0.0);
  }
  EXPECT_EQ(fresh.refused_poses, 0U);
  EXPECT_EQ(fresh.refused_for, core::Duration{0});
}

constexpr float kTick_s = 0.01F;
constexpr float kGravity_m_s2 = 9.8066F;
using Vector2 = core::Vector<float, 2>;

/// Single precision, as on the board, where the square of 1e30 overflows.
constexpr std::array kBad{std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30F};

class BadNumber : public ::testing::TestWithParam<float> {};
INSTANTIATE_TEST_SUITE_P(Checks, BadNumber, ::testing::ValuesIn(kBad), [](const auto& tested) {
  return std::isnan(tested.param) ? "NaN" : std::isinf(tested.param) ? "Infinity" : "Huge";
});

TEST_P(BadNumber, ATiltThatDoesNotAnswerIsStillSeen) {
  RecordProperty("promise", "R14");
  CommandConsistency<float> check;
  for (float t_s = 0.F; t_s < 4.F; t_s += kTick_s) {
    const bool bad = t_s > 1.F && t_s < 1.F + 1.5F * kTick_s;
    check.update({bad ? GetParam() : t_s, 0.F}, {.commanded_m_s2 = {1.F, 0.F}}, true, true, kTick_s);
  }
  EXPECT_TRUE(check.contradicts_command());
}

TEST_P(BadNumber, AnAttitudeWithOtherRatesIsStillSeen) {
  RecordProperty("promise", "R14");
  AttitudeRateConsistency<float> check;
  ImuSample<float> imu;
  imu.attitude_is_new = true;
  for (float t_s = 0.F; t_s < 4.F; t_s += kTick_s) {
    const bool bad = t_s > 1.F && t_s < 1.F + 1.5F * kTick_s;
    imu.roll_rad = 0.1F * std::sin(2.F * t_s);
    imu.rate_b_rad_s = {bad ? GetParam() : -0.2F * std::cos(2.F * t_s), 0.F, 0.F};
    check.update(imu, kTick_s);
  }
  EXPECT_TRUE(check.contradicts());
}

TEST_P(BadNumber, APathThatStandsIsStillSeen) {
  RecordProperty("promise", "R14");
  using PathInput = PathConsistency<float>::PathInput;
  for (Vector2 PathInput::*const input : {&PathInput::force_m_s2, &PathInput::position_m, &PathInput::speed_m_s}) {
    PathConsistency<float> check;
    Vector2 position_m = Vector2::Zero(), speed_m_s = Vector2::Zero();
    for (float t_s = 0.F; t_s < 20.F; t_s += kTick_s) {
      const Vector2 force_m_s2(std::sin(1.5F * t_s), 0.F);
      speed_m_s += force_m_s2 * kTick_s;
      position_m += speed_m_s * kTick_s;
      const float seen = t_s > 8.F ? 0.F : 1.F;  // then the pose stands still
      PathInput motion{.force_m_s2 = force_m_s2, .position_m = seen * position_m, .speed_m_s = seen * speed_m_s};
      if (t_s > 4.F && t_s < 4.F + 1.5F * kTick_s) {
        (motion.*input).x() = GetParam();
      }
      check.update(motion, true, kTick_s);
      EXPECT_TRUE(t_s < 7.F || t_s > 8.F || check.evidence() < 1.F) << "all is well again";
    }
    EXPECT_GE(check.evidence(), 1.F) << "input " << (input == &PathInput::force_m_s2 ? "force" : "place or speed");
  }
}

// A vehicle whose drag is no number spoils the state with every prediction.
TEST(BadVehicle, AStateThatIsNoNumberLastsForOneCallAndIsCalledSo) {
  model::Vehicle spoilt = vehicle();
  spoilt.translation.linear_drag_per_s = std::nan("");
  FloatEkf filter(spoilt);
  for (int tick = 0; tick < 200; ++tick) {
    Measurement<float> measured;
    measured.attitude.is_new = measured.pose.is_new = true;
    measured.now = core::TimePoint(tick * core::kTickPeriod);
    measured.pose.set_captured_at(measured.now);
    const Estimate<float>& e = filter.update(measured, {}, core::kTickPeriod);
    EXPECT_TRUE(std::isfinite(e.x.position_m + e.x.velocity_m_s + e.x.tilt_rad) && !e.healthy) << tick;
  }
  EXPECT_EQ(filter.counters().last_recovery, ResetReason::kNotFinite);
}

// Spoils each number of an estimate and of the autopilot's data once. Catches a check that ignores the force for a
// minute after one message of 1e30, because its mean length is spoilt.
TEST_P(BadNumber, APoseThatStandsIsStillContradicted) {
  RecordProperty("promise", "R14");
  const std::function<void(ImuSample<float>&, Estimate<float>&, float)> spoils[] = {
      [](ImuSample<float>& imu, Estimate<float>&, float bad) { imu.force_b.x() = bad; },
      [](ImuSample<float>& imu, Estimate<float>&, float bad) { imu.force_b.z() = bad; },
      [](ImuSample<float>& imu, Estimate<float>&, float bad) { imu.climb_m_s = bad; },
      [](ImuSample<float>& imu, Estimate<float>&, float bad) { imu.roll_rad = bad; },
      [](ImuSample<float>&, Estimate<float>& estimate, float bad) { estimate.x.velocity_m_s = bad; },
      [](ImuSample<float>&, Estimate<float>& estimate, float bad) { estimate.y.position_m = bad; },
      [](ImuSample<float>&, Estimate<float>& estimate, float bad) { estimate.height_m = bad; },
      [](ImuSample<float>&, Estimate<float>& estimate, float bad) { estimate.climb_m_s = bad; },
  };
  for (const auto& spoil : spoils) {
    VelocityConsistency<float> check;
    for (float t_s = 0.F; t_s < 20.F; t_s += kTick_s) {
      Estimate<float> estimate;
      estimate.healthy = true;
      ImuSample<float> imu{.attitude_is_new = true, .force_is_new = true, .climb_is_new = true};
      imu.force_b = {t_s > 15.F ? 1.5F : 0.F, 0.F, kGravity_m_s2};
      if (t_s > 5.F && t_s < 5.F + 1.5F * kTick_s) {
        spoil(imu, estimate, GetParam());
      }
      check.update(imu, estimate, Vector2::Zero(), core::kTickPeriod);
      EXPECT_TRUE(std::abs(t_s - 14.F) > 0.9F || check.report().check == ConsistencyCheck::kNone)
          << "all is well again";
    }
    EXPECT_NE(check.report().check, ConsistencyCheck::kNone) << "number " << (&spoil - spoils);
    EXPECT_TRUE(check.measured_h_m_s2().has_value()) << "number " << (&spoil - spoils);
  }
}

TEST_P(BadNumber, WhatIsReckonedIsANumberAgain) {
  RecordProperty("promise", "R14");
  DeadReckoning<float> reckoning;
  for (float t_s = 0.F; t_s < 4.F; t_s += kTick_s) {
    const bool bad = t_s > 1.F && t_s < 1.F + 1.5F * kTick_s;
    Estimate<float> estimate;
    estimate.prediction_valid = true;
    estimate.x.disturbance_m_s2 = bad ? GetParam() : 0.F;
    reckoning.update(ImuSample<float>{}, estimate, Vector2(bad ? GetParam() : 0.F, 0.F), true, false,
                     core::kTickPeriod);
  }
  EXPECT_LT(reckoning.velocity_w_m_s().norm(), 30.F);
  EXPECT_LT(reckoning.disturbance_acceleration_w_m_s2().norm(), 1.F);
}

}  // namespace
}  // namespace m100::est
