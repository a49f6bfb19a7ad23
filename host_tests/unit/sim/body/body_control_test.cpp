// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/body_control.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "firmware/model/vehicle.h"
#include "host_tests/sim/body/attitude_filter.h"
#include "host_tests/sim/body/climb_filter.h"
#include "host_tests/sim/body/rotor_mixer.h"

namespace m100::sim {
namespace {

using Vector3 = core::Vector<double, 3>;
constexpr double kStep_s = 0.0025;
constexpr double kGravity_m_s2 = model::kGravity_m_s2;

double mean(const RotorNumbers& rotors) { return (rotors[0] + rotors[1] + rotors[2] + rotors[3]) / 4.0; }

// ArduPilot's quadrotor in X. Catches exchanged rotors and signs: each axis alone must turn the body the right way.
TEST(RotorMixer, EachTorqueRaisesTheRightTwoRotors) {
  const RotorNumbers roll = RotorMixer::mix({.collective = 0.5, .roll = 0.1});  // right side down: the left ones
  EXPECT_GT(roll[1], 0.55);
  EXPECT_GT(roll[2], 0.55);
  const RotorNumbers pitch = RotorMixer::mix({.collective = 0.5, .pitch = 0.1});  // nose down: the rear ones
  EXPECT_GT(pitch[1], 0.55);
  EXPECT_GT(pitch[3], 0.55);
  const RotorNumbers yaw = RotorMixer::mix({.collective = 0.5, .yaw = 0.1});  // counter-clockwise: the clockwise rotors
  EXPECT_GT(yaw[2], 0.55);
  EXPECT_GT(yaw[3], 0.55);
  for (const RotorNumbers& rotors : {roll, pitch, yaw}) {
    EXPECT_NEAR(mean(rotors), 0.5, 1e-12);
  }
}

TEST(RotorMixer, GivesUpYawFirstThenHeightAndKeepsRollAndPitch) {
  const RotorNumbers high = RotorMixer::mix({.collective = 0.95, .roll = 0.2, .yaw = 0.2});
  EXPECT_NEAR(0.5 * (high[1] + high[2] - high[0] - high[3]), 0.4, 1e-12);  // all of the roll torque
  EXPECT_LT(mean(high), 0.95);
  EXPECT_LE(*std::max_element(high.begin(), high.end()), 1.0);
  const RotorNumbers low = RotorMixer::mix({.collective = 0.0, .pitch = 0.2});
  EXPECT_NEAR(0.5 * (low[1] + low[3] - low[0] - low[2]), 0.4, 1e-12);
  EXPECT_GE(*std::min_element(low.begin(), low.end()), RotorMixer::kIdle);
  const RotorNumbers full = RotorMixer::mix({.collective = 0.5, .roll = 0.4, .yaw = 0.3});
  EXPECT_NEAR(0.5 * (full[1] + full[2] - full[0] - full[3]), 0.8, 1e-12);
  const RotorNumbers beyond = RotorMixer::mix({.collective = 0.5, .roll = 3.0, .pitch = 3.0, .yaw = 0.3});
  for (const double rotor : beyond) {
    EXPECT_GE(rotor, RotorMixer::kIdle);
    EXPECT_LE(rotor, 1.0);
  }
}

TEST(RotorMixer, TheThrottleInvertsTheThrustCurve) {
  for (const double curve : {0.0, 0.65, 1.0}) {
    for (const double u : {0.0, 0.3, 1.0}) {
      EXPECT_NEAR(throttle_of((1.0 - curve) * u + curve * u * u, curve), u, 1e-12);
    }
  }
}

/// A rigid body for the loops alone: small angles about each axis, rotors with lag.
struct RigidBody {
  explicit RigidBody(const AutopilotNumbers& numbers, double rotor_lag_s, double hover_throttle, double thrust_power)
      : n(numbers), lag_s(rotor_lag_s), hover(hover_throttle), power(thrust_power) {}

  void step(const RotorNumbers& throttle) {
    RotorNumbers share{};  // of the hover thrust
    for (std::size_t i = 0; i < share.size(); ++i) {
      speed[i] += kStep_s / lag_s * (throttle[i] - speed[i]);
      share[i] = std::pow(speed[i] / hover, power);
    }
    const Vector3 acceleration(0.25 * n.roll_authority_rad_s2 * (share[1] + share[2] - share[0] - share[3]),
                               0.25 * n.pitch_authority_rad_s2 * (share[1] + share[3] - share[0] - share[2]),
                               0.25 * n.yaw_authority_rad_s2 * (share[2] + share[3] - share[0] - share[1]));
    motion.rate_b_rad_s += kStep_s * acceleration;
    motion.attitude.roll_rad += kStep_s * motion.rate_b_rad_s.x();
    motion.attitude.pitch_rad += kStep_s * motion.rate_b_rad_s.y();
    motion.climb_m_s += kStep_s * kGravity_m_s2 *
                        (mean(share) * std::cos(motion.attitude.roll_rad) * std::cos(motion.attitude.pitch_rad) - 1.0);
  }

  AutopilotNumbers n;
  double lag_s, hover, power;
  BodyMotion motion;
  RotorNumbers speed{};
};

struct Rotors {
  const char* name;
  double lag_s;
  double hover_throttle;
  double power;  ///< of the throttle that the thrust goes with
};
class BodyControlOn : public ::testing::TestWithParam<Rotors> {
 protected:
  void fly(const BodyCommand& command, double seconds) {
    for (double t_s = 0.0; t_s < seconds; t_s += kStep_s) {
      body.step(control.update(command, body.motion, kStep_s));
      highest_roll_rad = std::max(highest_roll_rad, body.motion.attitude.roll_rad);
    }
  }
  AutopilotNumbers numbers;
  BodyControl control{numbers};
  RigidBody body{numbers, GetParam().lag_s, GetParam().hover_throttle, GetParam().power};
  double highest_roll_rad = 0.0;
};

// Catches a wrong sign anywhere in the cascade, and gains that only fit one kind of rotor.
TEST_P(BodyControlOn, LearnsToHoverAndFollowsEveryCommand) {
  fly({}, 12.0);
  EXPECT_NEAR(body.motion.climb_m_s, 0.0, 0.01);
  fly({.roll_rad = 0.2}, 1.5);
  EXPECT_NEAR(body.motion.attitude.roll_rad, 0.2, 0.01);
  EXPECT_LT(highest_roll_rad, 0.25);  // overshoot below 25 %: the loops are damped with each of these rotors
  fly({.pitch_rad = -0.2}, 1.5);
  EXPECT_NEAR(body.motion.attitude.pitch_rad, -0.2, 0.01);
  EXPECT_NEAR(body.motion.attitude.roll_rad, 0.0, 0.01);
  fly({.climb_m_s = 1.0}, 4.0);
  EXPECT_NEAR(body.motion.climb_m_s, 1.0, 0.05);
  fly({.yaw_rate_rad_s = 0.5}, 3.0);
  EXPECT_NEAR(body.motion.rate_b_rad_s.z(), 0.5, 0.02);
}
INSTANTIATE_TEST_SUITE_P(Rotors, BodyControlOn,
                         ::testing::Values(Rotors{"M100", 0.025, 0.62, 2.0}, Rotors{"Slow", 0.05, 0.62, 2.0},
                                           Rotors{"Linear", 0.025, 0.38, 1.0}, Rotors{"Strong", 0.025, 0.4, 2.0},
                                           Rotors{"Weak", 0.03, 0.75, 2.0}),
                         [](const auto& one) { return one.param.name; });

// Rotors three times as slow as those that the gains are for: the phase margin is 7 degrees, with the derivative 25.
TEST(BodyControl, TheDerivativeDampsSlowRotors) {
  const auto swing_rad = [](double derivative_s) {
    AutopilotNumbers numbers;
    numbers.rate_derivative_s = derivative_s;
    BodyControl control(numbers);
    RigidBody body(numbers, 0.08, 0.62, 2.0);
    double largest = 0.0;
    for (double t_s = 0.0; t_s < 13.5; t_s += kStep_s) {
      const BodyCommand command{.roll_rad = t_s > 12.0 ? 0.2 : 0.0};
      body.step(control.update(command, body.motion, kStep_s));
      largest = t_s > 13.3 ? std::max(largest, std::abs(body.motion.attitude.roll_rad - 0.2)) : 0.0;
    }
    return largest;
  };
  EXPECT_LT(swing_rad(AutopilotNumbers{}.rate_derivative_s), 0.5 * swing_rad(0.0));
}

TEST(BodyControl, LearnsNothingOnTheGround) {
  BodyControl control{AutopilotNumbers{}};
  const double before = control.hover_thrust();
  for (int i = 0; i < 4000; ++i) {
    control.update({.climb_m_s = -0.5}, {.in_air = false}, kStep_s);
  }
  EXPECT_EQ(control.hover_thrust(), before);
}

// The claim at AutopilotNumbers: the gain looks like less drag, once for once, so it must be small.
TEST(AttitudeFilter, FollowsTheGyroAndDriftsToTheAccelerometerByItsGain) {
  AttitudeFilter filter(0.05);
  const Vector3 up(0.0, 0.0, kGravity_m_s2);
  filter.reset(Vector3(0.001, -0.002, 0.0), up, 0.3);
  for (int i = 0; i < 400; ++i) {  // a second of roll at 0.2 rad/s, seen by a biased gyro
    filter.update(Vector3(0.201, -0.002, 0.0), up, 0.3, kStep_s);
  }
  // The accelerometer keeps saying "level": 0.2 t and an error of k t^2 / 2 of it, less than 0.005 rad.
  EXPECT_NEAR(core::euler_of(filter.rotation_wb()).roll_rad, 0.195, 0.0015);
  EXPECT_NEAR(core::euler_of(filter.rotation_wb()).yaw_rad, 0.3, 0.01);
  for (int i = 0; i < 400 * 400; ++i) {  // ten time constants of the double pole at half the gain
    filter.update(Vector3(0.001, -0.002, 0.0), up, 0.3, kStep_s);
  }
  EXPECT_NEAR(core::euler_of(filter.rotation_wb()).roll_rad, 0.0, 0.001);
}

TEST(AttitudeFilter, StartsAtTheTiltOfTheSpecificForce) {
  AttitudeFilter filter(0.005);
  const core::Euler<double> tilt{.roll_rad = 0.1, .pitch_rad = -0.2, .yaw_rad = 0.0};
  const double sr = std::sin(0.1), cr = std::cos(0.1), sp = std::sin(-0.2), cp = std::cos(-0.2);
  filter.reset(Vector3::Zero(), kGravity_m_s2 * Vector3(-sp, sr * cp, cr * cp), 0.0);
  EXPECT_NEAR(core::euler_of(filter.rotation_wb()).roll_rad, tilt.roll_rad, 1e-12);
  EXPECT_NEAR(core::euler_of(filter.rotation_wb()).pitch_rad, tilt.pitch_rad, 1e-12);
  EXPECT_NEAR(filter.vertical_acceleration_m_s2(kGravity_m_s2 * Vector3(-sp, sr * cp, cr * cp)), 0.0, 1e-12);
}

TEST(ClimbFilter, FollowsAStepOfClimbAndForgetsABiasedAccelerometer) {
  ClimbFilter filter(5.0);
  filter.reset(0.0);
  double height_m = 0.0, climb_m_s = 0.0;
  for (double t_s = 0.0; t_s < 80.0; t_s += kStep_s) {
    const double acceleration = t_s < 1.0 ? 1.0 : 0.0;
    climb_m_s += kStep_s * acceleration;
    height_m += kStep_s * climb_m_s;
    filter.update(acceleration + 0.1, height_m, kStep_s);
    if (std::abs(t_s - 1.0) < 1e-9) {
      EXPECT_NEAR(filter.climb_m_s(), 1.0, 0.11);  // the accelerometer leads; its bias has had one second
    }
  }
  EXPECT_NEAR(filter.climb_m_s(), climb_m_s, 0.01);
}

}  // namespace
}  // namespace m100::sim
