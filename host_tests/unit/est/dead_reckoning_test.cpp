// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/dead_reckoning.h"

#include <gtest/gtest.h>

#include <cmath>

#include "firmware/core/tilt.h"

namespace m100::est {
namespace {

constexpr double kTick_s = 0.01;
constexpr double kGravity_m_s2 = 9.8066;
using Vector2 = core::Vector<double, 2>;

/// A tilted aircraft in a wind, and three witnesses of its motion; each test lets one of them lie.
class DeadReckoningTest : public ::testing::Test {
 protected:
  DeadReckoningTest() {
    estimate_.prediction_valid = true;
    imu_.attitude_is_new = true;
    turn_to(0.7);
  }
  void turn_to(double yaw_rad) { estimate_.yaw_rad = imu_.yaw_rad = yaw_rad; }

  /// @param tilt_m_s2 acceleration by the tilt, along the world's x.
  /// @param disturbance_m_s2 acceleration by the wind.
  void fly(double seconds, double tilt_m_s2, double disturbance_acceleration_m_s2) {
    for (double t_s = 0.0; t_s < seconds - 1e-9; t_s += kTick_s) {
      const double cosine = std::cos(estimate_.yaw_rad), sine = std::sin(estimate_.yaw_rad);
      const double total_m_s2 = tilt_m_s2 + disturbance_acceleration_m_s2;
      const core::Euler<double> attitude = core::attitude_of(core::Slope<double>{.x = tilt_m_s2 / kGravity_m_s2},
                                                             estimate_.yaw_rad, core::sin_cos_of(estimate_.yaw_rad));
      imu_.roll_rad = attitude.roll_rad;
      imu_.pitch_rad = attitude.pitch_rad;
      speed_m_s_ += total_m_s2 * kTick_s;
      if (pose_tells_) {
        estimate_.x.velocity_m_s = speed_m_s_;
        estimate_.x.disturbance_m_s2 = disturbance_acceleration_m_s2;
      }
      const double force_m_s2 = total_m_s2 + force_lies_m_s2_;
      measured_h_m_s2_ += (Vector2(cosine, -sine) * force_m_s2 - measured_h_m_s2_) * (kTick_s / kForceMean_s);
      dead_reckoning_.update(imu_, estimate_, measured_h_m_s2_, trusted_, pilots_, core::kTickPeriod);
    }
  }
  double error_m_s() const { return (dead_reckoning_.velocity_w_m_s() - Vector2(speed_m_s_, 0.0)).norm(); }

  DeadReckoning<double> dead_reckoning_;
  Estimate<double> estimate_;
  ImuSample<double> imu_;
  Vector2 measured_h_m_s2_ = Vector2::Zero();  ///< averaged as VelocityConsistency averages it
  double speed_m_s_ = 0.0;
  bool pose_tells_ = true;
  bool trusted_ = true;
  bool pilots_ = false;
  double force_lies_m_s2_ = 0.0;
};

// Before control is taken, the pose may show the speed of another body; that speed must not be braked afterwards.
TEST_F(DeadReckoningTest, WhileThePilotFliesItStands) {
  RecordProperty("promise", "R14");
  pilots_ = true;
  pose_tells_ = false;
  estimate_.x.velocity_m_s = 1.1;  // too fast for a hover
  fly(kTick_s, 0.0, 0.0);
  EXPECT_NEAR(dead_reckoning_.velocity_w_m_s().norm(), 0.0, 0.01) << "at the start";
  fly(20.0, 0.0, 0.0);
  EXPECT_NEAR(dead_reckoning_.velocity_w_m_s().x(), 1.1, 0.05);
  estimate_.x.velocity_m_s = 0.9;
  fly(0.5, 0.0, 0.0);
  EXPECT_NEAR(dead_reckoning_.velocity_w_m_s().x(), 1.1 / std::exp(1.0), 0.03);
  fly(3.0, 0.0, 0.0);
  EXPECT_NEAR(dead_reckoning_.velocity_w_m_s().norm(), 0.0, 0.01);
}

TEST_F(DeadReckoningTest, KnowsTheSpeedThatAnHonestFlightHas) {
  fly(5.0, -0.5, 0.5);
  fly(1.0, 3.0, 0.5);
  EXPECT_LT(error_m_s(), 0.1);
  fly(3.0, -2.0, 0.5);
  EXPECT_LT(error_m_s(), 0.15);
}

// Catches braking that uses estimates which the observer learned from the sensor fault.
TEST_F(DeadReckoningTest, RemembersTheMotionThatALyingPoseDenies) {
  RecordProperty("promise", "R14");
  fly(5.0, -0.5, 0.5);
  pose_tells_ = false;  // mirrored: shows the speed with the wrong sign, explained by a wind
  for (int tick = 0; tick < 80; ++tick) {
    fly(kTick_s, 2.0, 0.5);
    estimate_.x.velocity_m_s = -speed_m_s_;
    estimate_.x.disturbance_m_s2 = -4.5;
  }
  trusted_ = false;
  EXPECT_LT(error_m_s(), 0.5) << "of " << speed_m_s_ << " m/s, and the pose says " << -speed_m_s_;
  const double when_noticed_m_s = error_m_s();
  fly(1.0, -2.0, 0.5);
  EXPECT_NEAR(error_m_s(), when_noticed_m_s, 0.1) << "nothing of the sensor fault enters any more";
  EXPECT_NEAR(dead_reckoning_.disturbance_acceleration_w_m_s2().x(), 0.5, 0.15);
}

// Catches braking along a heading that the pose turned slowly enough to pass the innovation gate.
TEST_F(DeadReckoningTest, KeepsTheHeadingThatTheGyroscopesShow) {
  RecordProperty("promise", "R14");
  fly(5.0, 0.0, 0.0);
  for (int tick = 0; tick < 100; ++tick) {  // 1 rad in a second, of which the gyroscopes show 0.2
    estimate_.yaw_rate_rad_s = 0.2;
    turn_to(estimate_.yaw_rad + 0.01);
    fly(kTick_s, 0.0, 0.0);
  }
  trusted_ = false;
  estimate_.yaw_rate_rad_s = 0.0;
  turn_to(3.0);
  fly(1.0, 0.0, 0.0);
  estimate_.x.tilt_rad = 0.1;
  const Estimate<double> known = dead_reckoning_.replace_motion(estimate_);
  EXPECT_NEAR(known.yaw_rad, 0.9, 0.11) << "0.4 rad that were trusted on average for a second, of four";
  // The tilt keeps its direction in body axes.
  EXPECT_NEAR(std::atan2(-known.y.tilt_rad, known.x.tilt_rad), known.yaw_rad - 3.0, 1e-9);
  turn_to(0.5);
  trusted_ = true;
  fly(20.0, 0.0, 0.0);
  EXPECT_NEAR(dead_reckoning_.replace_motion(estimate_).yaw_rad, 0.5, 0.01);
}

// A hand at the frame, a tether or a new offset of the force: no tilt explains the force, and the pose shows no motion.
TEST_F(DeadReckoningTest, AForceThatNoTiltExplainsInventsNoMotion) {
  RecordProperty("promise", "R14");
  fly(5.0, 0.0, 0.0);
  force_lies_m_s2_ = 1.0;
  fly(1.0, 0.0, 0.0);
  trusted_ = false;
  fly(2.0, 0.0, 0.0);
  EXPECT_LT(error_m_s(), 0.05);
}

TEST_F(DeadReckoningTest, FollowsAWindThatPoseAndForceBothTell) {
  fly(10.0, 0.0, 0.0);
  fly(1.0, 0.0, 2.0);
  EXPECT_LT(error_m_s(), 0.25) << "of 2 m/s";
}

TEST_F(DeadReckoningTest, HandsOverTheMotionAndLeavesThePlace) {
  estimate_.x.position_m = 3.0;
  estimate_.y.input_offset_rad = 0.02;
  fly(2.0, 0.0, 0.3);
  const Estimate<double> known = dead_reckoning_.replace_motion(estimate_);
  EXPECT_EQ(known.x.position_m, 3.0);
  EXPECT_EQ(known.x.velocity_m_s, dead_reckoning_.velocity_w_m_s().x());
  EXPECT_EQ(known.y.disturbance_m_s2, dead_reckoning_.disturbance_acceleration_w_m_s2().y());
  EXPECT_NEAR(known.y.input_offset_rad, 0.02, 1e-9);
}

TEST_F(DeadReckoningTest, BeginsAnewWithTheObserver) {
  fly(2.0, 1.0, 0.0);
  estimate_.prediction_valid = false;
  fly(kTick_s, 0.0, 0.0);
  estimate_.prediction_valid = true;
  speed_m_s_ = -1.0;
  fly(kTick_s, 0.0, 0.0);
  EXPECT_LT(error_m_s(), 0.02);
}

}  // namespace
}  // namespace m100::est
