// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/velocity_consistency.h"

#include <gtest/gtest.h>

#include <cmath>

#include "firmware/core/tilt.h"

namespace m100::est {
namespace {

constexpr double kTick_s = 0.01;
constexpr double kGravity_m_s2 = 9.8066;

/// An aircraft whose pose and autopilot agree until a test makes them differ. Its position stays fixed: PathConsistency
/// has tests of its own.
class VelocityConsistencyTest : public ::testing::Test {
 protected:
  VelocityConsistencyTest() {
    estimate_.healthy = true;
    imu_ = {.attitude_is_new = true, .force_is_new = true, .climb_is_new = true};
    imu_.force_b = {0.0, 0.0, kGravity_m_s2};
    imu_.climb_m_s = 0.01;
  }
  void fly(double seconds, double acceleration_x_m_s2 = 0.0) {
    for (double t_s = 0.0; t_s < seconds - 1e-9; t_s += kTick_s) {
      estimate_.x.velocity_m_s += acceleration_x_m_s2 * kTick_s;
      check_.update(imu_, estimate_, disturbance_acceleration_w_m_s2_, core::kTickPeriod);
      silent_s_ += reported() == ConsistencyCheck::kNone ? kTick_s : 0.0;
    }
  }
  ConsistencyCheck reported() const { return check_.report().check; }

  VelocityConsistency<double> check_{set_of(ConsistencyCheck::kMotion)};
  Estimate<double> estimate_;
  ImuSample<double> imu_;
  core::Vector<double, 2> disturbance_acceleration_w_m_s2_ = core::Vector<double, 2>::Zero();
  double silent_s_ = 0.0;
};

TEST_F(VelocityConsistencyTest, IsSilentWhileBothAgreeUnderAnOffset) {
  imu_.force_b.x() = 0.4;  // as in measured logs: a few tenths of a m/s^2
  fly(60.0);
  imu_.force_b.x() += 2.0;
  fly(1.0, 2.0);
  imu_.force_b.x() -= 4.0;
  fly(1.0, -2.0);
  EXPECT_NEAR(silent_s_, 62.0, 0.001);
}

TEST_F(VelocityConsistencyTest, NamesAPoseThatStandsWhileTheForcePushes) {
  RecordProperty("promise", "R14");
  fly(20.0);
  imu_.force_b.x() = 0.8;
  fly(3.0);
  EXPECT_EQ(reported(), ConsistencyCheck::kForce);
  EXPECT_GT(check_.report().measured, check_.report().allowed);
}

// Telemetry that is missing for 0.2 to 0.34 s while a step reverses ended every flight as "check force".
TEST_F(VelocityConsistencyTest, AForceThatDidNotComeIsNoEvidence) {
  RecordProperty("promise", "R17");
  fly(20.0);
  for (const double acceleration_m_s2 : {4.0, -4.0, -4.0, 4.0}) {
    imu_.force_is_new = false;
    fly(0.34, acceleration_m_s2);
    imu_.force_is_new = true;
    imu_.force_b.x() = acceleration_m_s2;
    fly(0.3, acceleration_m_s2);
  }
  EXPECT_NEAR(silent_s_, 22.56, 0.02);
  imu_.force_is_new = false;
  fly(0.06);
  EXPECT_FALSE(check_.measured_h_m_s2().has_value()) << "an old force is no measurement";
  imu_.force_is_new = true;
  fly(2.0);  // the force goes on and the pose does not
  EXPECT_EQ(reported(), ConsistencyCheck::kForce);
}

// Catches a dead reckoning that goes on with the force of the last pose.
TEST_F(VelocityConsistencyTest, MeasuresTheAccelerationWithoutPosesToo) {
  fly(5.0);
  estimate_.healthy = false;
  imu_.force_b.x() = 2.0;
  fly(0.5);
  EXPECT_NEAR(check_.measured_h_m_s2()->x(), 2.0, 0.05);
}

TEST_F(VelocityConsistencyTest, TurnsTheForceWithTheHeading) {
  estimate_.yaw_rad = imu_.yaw_rad = M_PI / 2.0;
  fly(20.0);
  imu_.force_b.y() = -2.0;  // to the right of an aircraft that points along +y, which is the world's +x
  fly(1.0, 2.0);
  EXPECT_EQ(reported(), ConsistencyCheck::kNone);
  fly(1.0, -2.0);
  EXPECT_EQ(reported(), ConsistencyCheck::kForce);
}

TEST_F(VelocityConsistencyTest, TakesGravityOutOfATiltedForce) {
  fly(20.0);
  imu_.pitch_rad = 0.3;  // hovers against wind: a force of 1 g upwards in the world, none horizontally
  imu_.force_b = {-kGravity_m_s2 * std::sin(0.3), 0.0, kGravity_m_s2 * std::cos(0.3)};
  fly(5.0);
  EXPECT_EQ(reported(), ConsistencyCheck::kNone);
}

// The heading turns while the aircraft leans against a wind. Catches an offset that is kept in heading axes instead of
// body axes: its z component then turns with the lean, and a healthy pose was rejected as a sensor fault.
TEST_F(VelocityConsistencyTest, AnOffsetOfTheBodyThatLeansAgainstTheWindIsNoFaultInATurn) {
  RecordProperty("promise", "R17");
  constexpr double kLean = 0.33;  // slope, along the world's +x
  check_ = VelocityConsistency<double>();
  imu_.attitude_is_new = imu_.climb_is_new = false;  // only the force check runs
  imu_.climb_m_s = 0.0;
  double last_evidence_s = 0.0;
  for (double t_s = 0.0; t_s < 40.0; t_s += kTick_s) {
    const double turns_s = t_s < 8.0 ? 0.0 : t_s - 8.0;
    estimate_.yaw_rad = imu_.yaw_rad = 0.4 * turns_s;
    const core::Euler<double> lean = core::attitude_of(core::Slope<double>{.x = kLean, .y = 0.0}, estimate_.yaw_rad,
                                                       core::sin_cos_of(estimate_.yaw_rad));
    imu_.roll_rad = lean.roll_rad;
    imu_.pitch_rad = lean.pitch_rad;
    imu_.force_b = kGravity_m_s2 * core::Vector<double, 3>(-std::sin(lean.pitch_rad),
                                                           std::sin(lean.roll_rad) * std::cos(lean.pitch_rad),
                                                           std::cos(lean.roll_rad) * std::cos(lean.pitch_rad)) +
                   core::Vector<double, 3>(0.1, -0.2, 0.4);  // twice the sigma of measured logs
    check_.update(imu_, estimate_, disturbance_acceleration_w_m_s2_, core::kTickPeriod);
    ASSERT_EQ(reported(), ConsistencyCheck::kNone) << t_s << " s, " << name(reported());
    last_evidence_s = check_.is_suspect() ? t_s : last_evidence_s;
  }
  EXPECT_LT(last_evidence_s, 12.0) << "seconds into the flight, of doubt";
  EXPECT_NEAR(check_.measured_h_m_s2()->norm(), 0.0, 0.02) << "nothing moves";
}

// Catches a wind push that is rotated the wrong way, and one that still contains the tilt or the offset of the force.
TEST_F(VelocityConsistencyTest, ReportsTheAccelerationBesideThatOfTheTilt) {
  imu_.force_b.x() = 0.4;
  fly(60.0);
  EXPECT_NEAR(check_.disturbance_acceleration().now_w_m_s2.norm(), 0.0, 0.02) << "an offset is no push";
  EXPECT_FALSE(check_.disturbance_acceleration().is_known) << "no prediction to be mended";
  estimate_.prediction_valid = true;
  estimate_.yaw_rad = imu_.yaw_rad = M_PI / 2.0;
  imu_.pitch_rad = 0.2;  // tilted along the world's +y, with 0.5 m/s^2 of wind against it
  const double accelerates_m_s2 = kGravity_m_s2 * std::tan(0.2) - 0.5;
  imu_.force_b = {accelerates_m_s2 * std::cos(0.2) - kGravity_m_s2 * std::sin(0.2) + 0.4, 0.0,
                  kGravity_m_s2 * std::cos(0.2) + accelerates_m_s2 * std::sin(0.2)};
  fly(kTick_s);
  EXPECT_NEAR(check_.disturbance_acceleration().now_w_m_s2.x(), 0.0, 0.03);
  EXPECT_NEAR(check_.disturbance_acceleration().now_w_m_s2.y(), -0.5, 0.03);
  EXPECT_TRUE(check_.disturbance_acceleration().is_known);
  fly(0.5);
  EXPECT_NEAR(check_.disturbance_acceleration().mean_w_m_s2.y(), -0.5, 0.06);
  imu_.force_b /= 100.0;
  fly(5.0);
  EXPECT_FALSE(check_.disturbance_acceleration().is_known) << "no force at all";
}

TEST_F(VelocityConsistencyTest, AForceThatIsSwitchedOffGivesNoDisturbance) {
  check_ = VelocityConsistency<double>(set_of(ConsistencyCheck::kForce));
  estimate_.prediction_valid = true;
  imu_.force_b.x() = 2.0;
  fly(1.0, 1.0);
  EXPECT_FALSE(check_.disturbance_acceleration().is_known);
}

TEST_F(VelocityConsistencyTest, ReadsGAsWellAsMetresAndNothingWithoutGravity) {
  imu_.force_b /= kGravity_m_s2;
  fly(20.0);
  imu_.force_b.x() = 1.0 / kGravity_m_s2;
  fly(3.0);
  EXPECT_EQ(reported(), ConsistencyCheck::kForce);
  VelocityConsistency<double> other{set_of(ConsistencyCheck::kMotion)};
  std::swap(other, check_);
  imu_.force_b = {0.0, 0.0, 0.0};
  fly(20.0);
  imu_.force_b.x() = 0.3;
  fly(5.0);
  EXPECT_EQ(reported(), ConsistencyCheck::kNone) << "gravity is taken away: in which axes, nobody says";
}

// A mirrored pose while tilt and force grow as they do in the closed loop: the check must object before the aircraft
// is fast.
TEST_F(VelocityConsistencyTest, NamesAMirroredRunawayBeforeItIsFast) {
  RecordProperty("promise", "R14");
  fly(2.0);  // the check is still in its first seconds
  double speed_m_s = 0.0;
  for (double force_m_s2 = 0.2; reported() == ConsistencyCheck::kNone && speed_m_s < 3.0; force_m_s2 *= 1.04) {
    imu_.pitch_rad = std::atan2(force_m_s2, kGravity_m_s2);
    imu_.force_b.z() = std::hypot(force_m_s2, kGravity_m_s2);
    speed_m_s += force_m_s2 * kTick_s;
    fly(kTick_s, -force_m_s2);
  }
  EXPECT_EQ(reported(), ConsistencyCheck::kForce);
  EXPECT_LT(speed_m_s, 1.0);
}

TEST_F(VelocityConsistencyTest, AFaultIsNotLearnedAsAnOffset) {
  fly(5.0);
  imu_.force_b.x() = 1.5;
  fly(0.5, -1.5);
  EXPECT_TRUE(check_.is_suspect());
  const double sensed_m_s2 = check_.measured_h_m_s2()->x();
  fly(0.5, -1.5);
  EXPECT_NEAR(check_.measured_h_m_s2()->x(), sensed_m_s2, 0.05);
}

TEST_F(VelocityConsistencyTest, NamesAClimbThatTheAutopilotDoesNotMeasureAndZeroIsNoEvidence) {
  estimate_.climb_m_s = 0.31;
  imu_.climb_is_new = false;
  fly(5.0);
  EXPECT_EQ(reported(), ConsistencyCheck::kNone);
  imu_.climb_is_new = true;
  fly(1.1);
  EXPECT_EQ(reported(), ConsistencyCheck::kClimb);
}

// White noise of 18 mm at 100 Hz, ten times that of the vehicle file, leaves 0.3 m/s in the climb speed.
TEST_F(VelocityConsistencyTest, AllowsTheNoiseThatPosesLeaveInTheClimb) {
  estimate_.height_gain = 0.93;
  estimate_.climb_gain_per_s = 15.6;
  for (int tick = 0; tick < 1000; ++tick) {
    estimate_.climb_m_s = tick % 4 < 2 ? 0.31 : -0.31;
    estimate_.height_m = 0.058 * estimate_.climb_m_s;
    fly(kTick_s);
  }
  EXPECT_NEAR(silent_s_, 10.0, 1e-6);
}

// The gain of a climb is known within 30 %, and only where both channels climb by more than a hover does.
TEST_F(VelocityConsistencyTest, AllowsAClimbTheErrorOfItsGain) {
  const auto apart = [this](double pose_m_s, double autopilot_m_s) {
    check_ = VelocityConsistency<double>(set_of(ConsistencyCheck::kMotion));
    estimate_.climb_m_s = pose_m_s;
    imu_.climb_m_s = autopilot_m_s;
    fly(4.0);
    return reported() == ConsistencyCheck::kClimb;
  };
  for (const double way : {1.0, -1.0}) {
    EXPECT_FALSE(apart(way * 1.65, way * 1.23)) << "0.2 and 0.3 (1.23 - 0.2) m/s allowed";
    EXPECT_TRUE(apart(way * 1.95, way * 1.23));
    EXPECT_FALSE(apart(way * 1.2, way * 1.62));
    EXPECT_TRUE(apart(way * 1.2, way * 1.95));
    EXPECT_TRUE(apart(way * 1.65, way * 0.02));
    EXPECT_TRUE(apart(way * 0.02, way * 1.65));
  }
}

TEST_F(VelocityConsistencyTest, NamesATurnAndForgivesACompassThatDrifts) {
  for (int i = 0; i < 1000; ++i) {
    imu_.yaw_rad += 0.0003;  // 1.7 degrees a second
    fly(kTick_s);
  }
  EXPECT_EQ(reported(), ConsistencyCheck::kNone);
  estimate_.yaw_rad += 0.6;
  fly(0.5);
  EXPECT_EQ(reported(), ConsistencyCheck::kHeading);
}

// Catches a check that calls the pose wrong when the compass jumps, and one that misses a pose that stands in a turn.
TEST_F(VelocityConsistencyTest, OfThreeHeadingsTwoOutvoteTheThird) {
  for (const double jump_rad : {0.25, 0.35, -1.05, 3.0}) {
    check_ = VelocityConsistency<double>(set_of(ConsistencyCheck::kMotion));
    fly(10.0);
    imu_.yaw_rad += jump_rad;
    fly(kTick_s);
    EXPECT_NEAR(check_.heading_turned_alone_rad(), std::abs(jump_rad), 0.01);
    fly(20.0);
    EXPECT_EQ(reported(), ConsistencyCheck::kNone) << jump_rad;
  }
  for (const auto [gyro_rad_s, pose_rad_s] : {std::array{0.5, 0.5}, std::array{0.0, 0.5}, std::array{0.5, 0.0}}) {
    check_ = VelocityConsistency<double>(set_of(ConsistencyCheck::kMotion));
    fly(10.0);
    imu_.rate_b_rad_s.z() = gyro_rad_s;
    for (int i = 0; i < 200; ++i, imu_.yaw_rad += 0.5 * kTick_s, estimate_.yaw_rad += pose_rad_s * kTick_s) {
      fly(kTick_s);
    }
    imu_.rate_b_rad_s.z() = 0.0;
    EXPECT_EQ(reported(), pose_rad_s > 0.0 ? ConsistencyCheck::kNone : ConsistencyCheck::kHeading) << gyro_rad_s;
  }
}

TEST_F(VelocityConsistencyTest, AnOverriddenCheckIsSilentAndTheOthersAreNot) {
  check_ = VelocityConsistency<double>(set_of(ConsistencyCheck::kForce));
  fly(20.0);
  imu_.force_b.x() = 2.0;
  fly(3.0);
  EXPECT_EQ(reported(), ConsistencyCheck::kNone);
  estimate_.climb_m_s = 1.0;
  fly(1.0);
  EXPECT_EQ(reported(), ConsistencyCheck::kClimb);
}

TEST_F(VelocityConsistencyTest, TakesItBackWhenBothAgreeAgain) {
  fly(5.0);
  estimate_.climb_m_s = 1.0;
  fly(1.0);
  ASSERT_EQ(reported(), ConsistencyCheck::kClimb);
  estimate_.climb_m_s = 0.0;
  fly(1.0);
  EXPECT_EQ(reported(), ConsistencyCheck::kNone);
}

TEST_F(VelocityConsistencyTest, JudgesNothingThatTheObserverDoesNotUse) {
  fly(20.0);
  estimate_.pose_age = std::chrono::milliseconds(400);
  fly(0.5, 3.0);
  EXPECT_EQ(reported(), ConsistencyCheck::kNone);
}

// A picked-up load changes the climb speed by 0.15 m/s between two messages. The force does not show it, but the
// autopilot's own climb speed does. Catches a vertical check that takes the jerk for a sensor fault.
TEST_F(VelocityConsistencyTest, ABlowThatTheAutopilotsOwnClimbHasIsNoFault) {
  RecordProperty("promise", "R17");
  check_ = VelocityConsistency<double>();
  fly(10.0);
  double climb_m_s = -0.15;
  for (double t_s = 0.0; t_s < 6.0; t_s += kTick_s) {
    estimate_.climb_m_s = climb_m_s;
    estimate_.height_m += climb_m_s * kTick_s;
    imu_.climb_m_s = climb_m_s + 0.001;
    imu_.force_b.z() = kGravity_m_s2 - climb_m_s / 0.3;
    fly(kTick_s);
    ASSERT_EQ(reported(), ConsistencyCheck::kNone) << t_s;
    climb_m_s -= climb_m_s * kTick_s / 0.3;
  }
}

TEST_F(VelocityConsistencyTest, NamesAHeightThatStandsWhileTheForceLifts) {
  RecordProperty("promise", "R14");
  check_ = VelocityConsistency<double>(set_of(ConsistencyCheck::kClimb));
  fly(10.0);
  double spoke_s = 0.0;
  for (; spoke_s < 5.0 && reported() == ConsistencyCheck::kNone; spoke_s += kTick_s) {
    imu_.force_b.z() = kGravity_m_s2 + 0.35 * std::cos(5.0 * spoke_s);
    imu_.climb_m_s = 0.07 * std::sin(5.0 * spoke_s) + 1e-4;
    fly(kTick_s);
  }
  EXPECT_EQ(reported(), ConsistencyCheck::kMotion);
  EXPECT_LT(spoke_s, 2.0);
}

// The smallest faults that the checks' headers claim to see in 3 s of a calm hover, from both sides.
TEST_F(VelocityConsistencyTest, SeesTheSmallestFaultInThreeSecondsAndNotThreeQuartersOfIt) {
  const auto reported_after = [this](double force_m_s2, double climb_m_s, double turn_rad) {
    check_ = VelocityConsistency<double>(set_of(ConsistencyCheck::kMotion));
    fly(60.0);
    const ImuSample<double> calm = imu_;
    imu_.force_b.x() = force_m_s2;
    imu_.climb_m_s -= climb_m_s;
    estimate_.yaw_rad += turn_rad;
    fly(3.0);
    estimate_.yaw_rad -= turn_rad;
    imu_ = calm;
    return reported();
  };
  EXPECT_EQ(reported_after(0.13, 0.0, 0.0), ConsistencyCheck::kForce);
  EXPECT_EQ(reported_after(0.0975, 0.0, 0.0), ConsistencyCheck::kNone);
  EXPECT_EQ(reported_after(0.0, 0.26, 0.0), ConsistencyCheck::kClimb);
  EXPECT_EQ(reported_after(0.0, 0.195, 0.0), ConsistencyCheck::kNone);
  EXPECT_EQ(reported_after(0.0, 0.0, 0.33), ConsistencyCheck::kHeading);
  EXPECT_EQ(reported_after(0.0, 0.0, 0.25), ConsistencyCheck::kNone);
}

TEST(ConsistencyCheck, EveryCheckIsFoundByItsName) {
  for (std::size_t i = 1; i < kCheckCount; ++i) {
    EXPECT_EQ(check_of(name(static_cast<ConsistencyCheck>(i))), static_cast<ConsistencyCheck>(i));
  }
  EXPECT_FALSE(check_of("none").has_value());
}

// Too slow for the force check, so only the path tells; each axis has its own.
TEST_F(VelocityConsistencyTest, NamesAPathThatNoForceMakesAlongEachAxis) {
  for (AxisEstimate<double> Estimate<double>::*axis : {&Estimate<double>::x, &Estimate<double>::y}) {
    check_ = VelocityConsistency<double>();
    estimate_.x = estimate_.y = {};
    fly(10.0);
    double spoke_s = 0.0;
    const auto sway = [&] {
      (estimate_.*axis).position_m = 0.03 * std::sin(2.0 * spoke_s);
      (estimate_.*axis).velocity_m_s = 0.06 * std::cos(2.0 * spoke_s);
      fly(kTick_s);
    };
    for (; spoke_s < 5.0 && reported() == ConsistencyCheck::kNone; spoke_s += kTick_s) {
      sway();
    }
    EXPECT_EQ(reported(), ConsistencyCheck::kMotion);
    EXPECT_LT(spoke_s, 3.0);
    // The force bridges a second without poses, which takes nothing back; after that the path begins anew.
    for (const int age_ms : {300, 310, 600, 1000, 1010}) {
      estimate_.pose_age = std::chrono::milliseconds(age_ms);
      sway();
      EXPECT_EQ(reported(), age_ms > 1000 ? ConsistencyCheck::kNone : ConsistencyCheck::kMotion) << age_ms;
    }
    estimate_.pose_age = core::Duration{0};
  }
}

}  // namespace
}  // namespace m100::est
