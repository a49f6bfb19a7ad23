// SPDX-License-Identifier: BSD-3-Clause
// Which sensor is wrong if the attitude does not follow our commands? That alone does not decide it; the poses are a
// second witness.
#include "firmware/app/fault_isolation.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "firmware/model/vehicle.h"

namespace m100::app {
namespace {

using Vector2 = core::Vector<double, 2>;

/// Commands that alternate on both axes, as fast as an oscillating loop.
Vector2 model_tilt_rad(double t_s) { return {0.1 * std::sin(2.5 * t_s), 0.08 * std::cos(3.1 * t_s)}; }

/// Runs four seconds in which the attitude is the opposite of the command, and no force is measured.
/// @param follows 1: the poses move as the commands tilt, -1: as the attitude does
/// @param is_new false: the same poses, but they came before
/// @param off checks that are switched off
/// @returns the judge at the end
FaultIsolation<double> trust_after(double follows, bool is_new = true, est::CheckSet off = 0) {
  FaultIsolation<double> trust(off);
  safety::FailsafeState state = safety::FailsafeState::kNominal;  // and kLevel after a contradiction
  Vector2 velocity_m_s = Vector2::Zero(), place_m = Vector2::Zero();
  for (int tick = 1; tick <= 400; ++tick) {
    const Vector2 asked = model_tilt_rad(0.01 * tick);
    velocity_m_s += follows * model::kGravity_m_s2 * 0.01 * Vector2(asked.x(), -asked.y());
    place_m += 0.01 * velocity_m_s;
    est::Estimate<double> estimate;
    estimate.x.position_m = tick == 1 ? std::nan("") : 0.0;  // must not stay in a mean
    estimate.prediction_valid = true;
    estimate.refused_poses = 1;
    estimate.x.tilt_rad = -asked.x();
    estimate.y.tilt_rad = -asked.y();
    est::ImuSample<double> imu;
    imu.attitude_is_new = true;
    imu.pitch_rad = estimate.x.tilt_rad;
    imu.roll_rad = estimate.y.tilt_rad;
    const Vector2 turned_rad = model_tilt_rad(0.01 * (tick - 1)) - asked;
    imu.rate_b_rad_s = {turned_rad.y() / 0.01, turned_rad.x() / 0.01, 0.0};
    est::Measurement<double> measured;
    measured.now = core::TimePoint(core::kTickPeriod * tick);
    measured.pose.is_new = is_new;
    measured.pose.set_captured_at(measured.now);
    measured.pose.position_w_m.head<2>() = place_m;
    trust.update(imu, measured, estimate, asked, state, core::kTickPeriod);
    state = trust.contradiction().check == est::ConsistencyCheck::kNone ? state : safety::FailsafeState::kLevel;
  }
  return trust;
}

// Would catch a FaultIsolation that needs a further objection before it rejects the attitude: force and observer both
// follow an attitude that is wrong from the beginning.
TEST(FaultIsolation, PosesThatMoveAsTheCommandsAccuseAnAttitudeThatDoesNotAnswer) {
  RecordProperty("promise", "R14");
  EXPECT_TRUE(trust_after(1.0).attitude_is_contradicted());
  EXPECT_TRUE(trust_after(1.0, true, set_of(est::ConsistencyCheck::kHeight)).attitude_is_contradicted());
  EXPECT_FALSE(trust_after(1.0, true, set_of(est::ConsistencyCheck::kAnswer)).attitude_is_contradicted());
}

TEST(FaultIsolation, AnAttitudeThatDoesNotAnswerIsNotAccusedByItself) {
  RecordProperty("promise", "R17");
  EXPECT_FALSE(trust_after(-1.0).attitude_is_contradicted()) << "the poses move as the attitude does";
}

TEST(FaultIsolation, APoseThatCameBeforeIsNoSecondWitness) {
  EXPECT_FALSE(trust_after(1.0, false).attitude_is_contradicted());
}

// While the attitude is contradicted, the tilt is the commands', each axis its own.
TEST(FaultIsolation, TheMotionForBrakingHasTheTiltOfTheCommands) {
  const FaultIsolation<double> trust = trust_after(1.0);
  est::Estimate<double> estimate;
  estimate.x.tilt_rad = 0.3;
  estimate.y.tilt_rad = -0.4;
  const est::Estimate<double> known = trust.motion(estimate);
  const Vector2 asked = model_tilt_rad(4.0);
  EXPECT_NEAR(known.x.tilt_rad, asked.x(), 0.01);  // the offset that the reckoning has learned is small
  EXPECT_NEAR(known.y.tilt_rad, asked.y(), 0.01);
  EXPECT_GT(std::abs(asked.x() - asked.y()), 0.05) << "a test that cannot tell the axes apart";
  const FaultIsolation<double> innocent = trust_after(-1.0);
  EXPECT_EQ(innocent.motion(estimate).x.tilt_rad, 0.3);
  EXPECT_EQ(innocent.motion(estimate).y.tilt_rad, -0.4);
}

// Without an attitude the poses and our commands still show the motion, so the aircraft is braked and not only
// levelled.
TEST(FaultIsolation, WithoutAnAttitudeTheVelocityIsThatOfThePoses) {
  RecordProperty("promise", "R14");
  FaultIsolation<double> trust({});
  est::Estimate<double> estimate;  // no prediction is valid
  const auto fly_until = [&](int last, int first, int every) {
    for (int tick = first; tick <= last; ++tick) {
      est::Measurement<double> measured;
      measured.now = core::TimePoint(core::kTickPeriod * tick);
      measured.pose.is_new = tick % every == 0;
      measured.pose.set_captured_at(measured.now - std::chrono::milliseconds(30));
      measured.pose.position_w_m.head<2>() = Vector2(1.0, -0.5) * (0.01 * tick - 0.03);
      trust.update({}, measured, estimate, {0.0, 0.01}, safety::FailsafeState::kLevel, core::kTickPeriod);
    }
  };
  fly_until(100, 1, 3);
  EXPECT_TRUE(trust.motion(estimate).prediction_valid);
  EXPECT_NEAR(trust.motion(estimate).x.velocity_m_s, 1.0, 0.03);
  EXPECT_NEAR(trust.motion(estimate).y.velocity_m_s, -0.5, 0.03) << "our commands push by 0.1 m/s^2";
  EXPECT_NEAR(trust.speed_m_s(estimate), std::hypot(1.0, 0.5), 0.03);
  fly_until(400, 101, 1000);
  EXPECT_FALSE(trust.motion(estimate).prediction_valid) << "no pose for two seconds";
}

/// Moves, leans and is pushed differently along each axis.
est::Estimate<double> moving(double along) {
  est::Estimate<double> estimate;
  estimate.prediction_valid = true;
  estimate.x = {.velocity_m_s = 1.0, .tilt_rad = along * 0.1, .disturbance_m_s2 = along * 0.3};
  estimate.y = {.velocity_m_s = 0.5, .tilt_rad = along * -0.2, .disturbance_m_s2 = along * -0.4};
  return estimate;
}

// A contradiction that has ended is remembered as long as the aircraft is levelled or given back, and no longer.
TEST(FaultIsolation, TheContradictionIsRememberedUntilTheFailsafeHasEnded) {
  for (const safety::FailsafeState state :
       {safety::FailsafeState::kLevel, safety::FailsafeState::kRelease, safety::FailsafeState::kNominal}) {
    FaultIsolation<double> trust = trust_after(1.0);
    est::Estimate<double> estimate = moving(1.0);
    for (int tick = 401; tick <= 1000; ++tick) {
      const Vector2 asked = model_tilt_rad(0.01 * tick);
      estimate.x.tilt_rad = asked.x();
      estimate.y.tilt_rad = asked.y();
      est::Measurement<double> measured;
      measured.now = core::TimePoint(core::kTickPeriod * tick);
      trust.update({}, measured, estimate, asked, state, core::kTickPeriod);
    }
    ASSERT_EQ(trust.contradiction().check, est::ConsistencyCheck::kNone);
    const bool is_estimate = trust.motion(estimate).x.velocity_m_s == estimate.x.velocity_m_s;
    EXPECT_EQ(is_estimate, state == safety::FailsafeState::kNominal) << static_cast<int>(state);
    estimate.x.velocity_m_s += 1.0;  // false again: the way flown unseen begins anew
    estimate.refused_poses = 1;
    trust.update({}, {}, estimate, {0.0, 0.0}, safety::FailsafeState::kLevel, core::kTickPeriod);
    ASSERT_TRUE(trust.fence_motion(estimate).has_value());
    EXPECT_EQ(std::abs(trust.fence_motion(estimate)->x.position_m) < 0.05, state == safety::FailsafeState::kNominal);
  }
}

// A false force said that nothing accelerates: the speed that the tilt still gained while it turned round was called
// useless, and the aircraft was levelled at 1.5 m/s.
TEST(FaultIsolation, ASpeedThatGrowsUntilTheTiltIsReversedIsUsed) {
  for (const double lean_rad : {0.0, 0.45, -0.45}) {
    FaultIsolation<double> trust({});
    est::Estimate<double> estimate = moving(0.0);
    est::ImuSample<double> imu;
    imu.attitude_is_new = true;
    imu.rate_b_rad_s.setZero();
    imu.pitch_rad = 0.45;
    for (int tick = 1; tick <= 60; ++tick) {
      const bool ends = tick > 40;
      estimate.refused_poses = ends ? 1 : 0;
      estimate.x.tilt_rad = lean_rad;  // the attitude follows the commands
      estimate.y.velocity_m_s = ends ? 1.5 : 0.5;
      trust.update(imu, {}, estimate, {lean_rad, 0.0},
                   ends ? safety::FailsafeState::kLevel : safety::FailsafeState::kNominal, core::kTickPeriod);
    }
    EXPECT_EQ(trust.motion(estimate).x.velocity_variance_m2_s2<1e3, lean_rad> 0.0) << lean_rad;
  }
}

/// The motion for braking after some time at level, in which the commands hold this tilt.
est::Estimate<double> reckoned_with(const Vector2& asked, int ticks = 300, double* speed_m_s = nullptr) {
  FaultIsolation<double> trust = trust_after(1.0);
  est::Estimate<double> estimate = moving(0.0);
  for (int tick = 401; tick <= 400 + ticks; ++tick) {
    est::Measurement<double> measured;
    measured.now = core::TimePoint(core::kTickPeriod * tick);
    trust.update({}, measured, estimate, asked, safety::FailsafeState::kLevel, core::kTickPeriod);
  }
  if (speed_m_s != nullptr) {
    *speed_m_s = trust.speed_m_s(estimate);
  }
  return trust.motion(estimate);
}

// With an attitude that is contradicted, the motion is computed from the commands, each axis from its own.
TEST(FaultIsolation, TheReckonedVelocityFollowsTheTiltOfTheCommands) {
  const double g = model::kGravity_m_s2;
  const est::Estimate<double> level = reckoned_with({0.0, 0.0});
  const est::Estimate<double> along_x = reckoned_with({0.02, 0.0});
  EXPECT_NEAR(along_x.x.velocity_m_s - level.x.velocity_m_s, 3.0 * g * 0.02, 0.02);
  EXPECT_NEAR(along_x.y.velocity_m_s - level.y.velocity_m_s, 0.0, 0.02);
  const est::Estimate<double> along_y = reckoned_with({0.0, 0.02});
  EXPECT_NEAR(along_y.x.velocity_m_s - level.x.velocity_m_s, 0.0, 0.02);
  EXPECT_NEAR(along_y.y.velocity_m_s - level.y.velocity_m_s, -3.0 * g * 0.02, 0.02);
}

// Poses of 1.4 s ago came again after a gap and were braked against: handed over at 1.9 m/s.
TEST(FaultIsolation, PosesThatComeAgainElsewhereAreNotBrakedAgainst) {
  RecordProperty("promise", "R14");
  for (const double velocity_m_s : {-0.6, 0.1}) {
    FaultIsolation<double> trust({});
    est::Estimate<double> estimate = moving(0.0);
    for (int tick = 1; tick <= 140; ++tick) {
      const bool gap = tick > 50 && tick <= 130;
      estimate.x.velocity_m_s = tick <= 130 ? 0.0 : velocity_m_s;
      estimate.y.velocity_m_s = 0.0;
      estimate.pose_age = std::chrono::milliseconds(gap ? 10 * (tick - 50) : 20);
      trust.update({}, {}, estimate, {0.0, 0.0},
                   tick > 50 ? safety::FailsafeState::kLevel : safety::FailsafeState::kNominal, core::kTickPeriod);
    }
    EXPECT_EQ(trust.motion(estimate).x.velocity_m_s == velocity_m_s, velocity_m_s == 0.1) << velocity_m_s;
  }
}

// A speed that grows while the aircraft brakes is useless: nothing waits for it to fall.
TEST(FaultIsolation, AReckonedSpeedThatRunsAwayIsNotUsed) {
  double speed_m_s = -1.0;
  EXPECT_GE(reckoned_with({0.3, 0.0}, 300, &speed_m_s).x.velocity_variance_m2_s2, 1e6);
  EXPECT_EQ(speed_m_s, 0.0);
  EXPECT_LT(reckoned_with({0.3, 0.0}, 1, &speed_m_s).x.velocity_variance_m2_s2, 1e6);
  EXPECT_GT(speed_m_s, 0.0) << "it has not grown yet";
}

// Numbers by hand: the acceleration is 0.3 + 0.1 g along x and -0.4 + 0.2 g along y, because tilt.y accelerates against
// y; half a second of it is added to the velocity.
TEST(FaultIsolation, TheSpeedAtTheHandOverIsThatOfTheAccelerationUntilThen) {
  const FaultIsolation<double> trust({});
  const double g = model::kGravity_m_s2;
  const double x_m_s = 1.0 + 0.5 * (0.3 + 0.1 * g);
  const double y_m_s = 0.5 + 0.5 * (-0.4 + 0.2 * g);
  EXPECT_NEAR(trust.speed_then_m_s(moving(1.0), std::chrono::milliseconds(500)), std::hypot(x_m_s, y_m_s), 1e-9);
  const double later_x_m_s = 1.0 + 2.0 * (0.3 + 0.1 * g);
  const double later_y_m_s = 0.5 + 2.0 * (-0.4 + 0.2 * g);
  EXPECT_NEAR(trust.speed_then_m_s(moving(1.0), std::chrono::seconds(2)), std::hypot(later_x_m_s, later_y_m_s), 1e-9);
}

TEST(FaultIsolation, AnAircraftThatBrakesIsAsFastAtTheHandOverAsNow) {
  const FaultIsolation<double> trust({});
  EXPECT_NEAR(trust.speed_then_m_s(moving(-1.0), std::chrono::milliseconds(500)), std::hypot(1.0, 0.5), 1e-9);
  est::Estimate<double> slow;  // that it is slow excuses nothing
  slow.prediction_valid = true;
  slow.x = {.velocity_m_s = 0.1, .disturbance_m_s2 = 0.5};
  EXPECT_NEAR(trust.speed_then_m_s(slow, std::chrono::seconds(1)), 0.6, 1e-9);
}

TEST(FaultIsolation, ASpeedThatIsNotKnownIsZero) {
  const FaultIsolation<double> trust({});
  EXPECT_NEAR(trust.speed_m_s(moving(1.0)), std::hypot(1.0, 0.5), 1e-9);
  est::Estimate<double> unknown = moving(1.0);
  unknown.prediction_valid = false;
  EXPECT_EQ(trust.speed_m_s(unknown), 0.0);
  EXPECT_EQ(trust.speed_then_m_s(unknown, std::chrono::seconds(1)), 0.0)
      << "nothing waits for an unknown speed to fall";
  for (est::AxisEstimate<double> est::Estimate<double>::*axis :
       {&est::Estimate<double>::x, &est::Estimate<double>::y}) {
    est::Estimate<double> vague = moving(1.0);
    (vague.*axis).velocity_variance_m2_s2 = 0.99;
    EXPECT_GT(trust.speed_m_s(vague), 1.0);
    (vague.*axis).velocity_variance_m2_s2 = 1.0;
    EXPECT_EQ(trust.speed_m_s(vague), 0.0) << "one axis is enough";
  }
}

// Each number of the observation comes from its own place.
TEST(FaultIsolation, TellsTheRefusalNumberByNumber) {
  const FaultIsolation<double> trust({});
  est::Estimate<double> estimate = moving(1.0);
  estimate.refused_poses = 7;
  estimate.refused_for = std::chrono::milliseconds(130);
  estimate.refusal = {.distance_m = 0.4, .allowed_m = 0.3, .turned_rad = 0.2};
  const est::ConsistencyStatus observed = trust.status(estimate, safety::FailsafeState::kNominal, false, {});
  EXPECT_EQ(observed.refused_poses, 7U);
  EXPECT_EQ(observed.refused_for, std::chrono::milliseconds(130)) << "no pose is contradicted";
  EXPECT_EQ(observed.refused_by_m, 0.4);
  EXPECT_EQ(observed.refused_allowed_m, 0.3);
  EXPECT_EQ(observed.refused_turn_rad, 0.2);
  EXPECT_NEAR(observed.speed_m_s, std::hypot(1.0, 0.5), 1e-9);
  EXPECT_EQ(observed.speed_then_m_s, 0.0) << "nothing is handed over";
  const safety::Limits limits;
  EXPECT_EQ(trust.status(estimate, safety::FailsafeState::kLevel, false, limits).speed_then_m_s,
            trust.speed_then_m_s(estimate, limits.neutral));
  const est::ConsistencyStatus swinging = trust.status(estimate, safety::FailsafeState::kLevel, true, limits);
  EXPECT_EQ(swinging.speed_m_s, 0.0) << "nothing reduces it";
  EXPECT_EQ(swinging.speed_then_m_s, 0.0);
}

// The reckoned velocity of an aircraft that nobody has flown is zero.
TEST(FaultIsolation, RefusedPosesAreFalseIfTheObserverIsHalfAMetrePerSecondOff) {
  for (const double speed_m_s : {0.45, 0.55}) {
    for (const std::uint32_t refused : {0U, 1U}) {
      for (const auto state : {safety::FailsafeState::kNominal, safety::FailsafeState::kLevel}) {
        FaultIsolation<double> isolation({});
        est::Estimate<double> estimate;
        estimate.refused_poses = refused;
        estimate.x.velocity_m_s = 0.6 * speed_m_s;
        estimate.y.velocity_m_s = -0.8 * speed_m_s;
        isolation.update({}, {}, estimate, {0.0, 0.0}, state, core::kTickPeriod);
        EXPECT_EQ(isolation.motion(estimate).x.velocity_m_s != estimate.x.velocity_m_s,
                  speed_m_s > 0.5 && refused > 0 && state == safety::FailsafeState::kLevel);
      }
    }
  }
}

TEST(FaultIsolation, AnAttitudeAgainstItsRatesIsNamedUnlessThatCheckIsOff) {
  for (const est::CheckSet off : {est::CheckSet{0}, set_of(est::ConsistencyCheck::kRates)}) {
    FaultIsolation<double> isolation(off);
    for (int tick = 1; tick <= 270; ++tick) {
      const est::ImuSample<double> imu{.attitude_is_new = true, .roll_rad = 0.1 * std::sin(0.05 * tick)};
      isolation.update(imu, {}, {}, {0.0, 0.0}, safety::FailsafeState::kNominal, core::kTickPeriod);
    }
    const est::Contradiction<double> found = isolation.contradiction();
    EXPECT_EQ(found.check, off != 0 ? est::ConsistencyCheck::kNone : est::ConsistencyCheck::kRates);
    EXPECT_EQ(found.measured > found.allowed, off == 0);
    EXPECT_EQ(isolation.attitude_is_contradicted(), off == 0);
  }
}

// A pose that rises by 4 m in 10 s although neither the autopilot's height nor its climb speed does: the fence is held
// by all but what an honest barometer wanders.
TEST(FaultIsolation, ADriftingHeightIsNamedInControlUnlessThatCheckIsOff) {
  for (const est::CheckSet off : {est::CheckSet{0}, set_of(est::ConsistencyCheck::kHeight)}) {
    for (const auto state : {safety::FailsafeState::kNominal, safety::FailsafeState::kSilent}) {
      FaultIsolation<double> isolation(off);
      est::Estimate<double> estimate;
      estimate.healthy = true;
      for (int tick = 0; tick <= 1000; ++tick) {
        estimate.height_m = 1.5 + 0.004 * tick;
        est::ImuSample<double> imu{.climb_is_new = true, .height_is_new = true};
        imu.height_m = 3.0;
        isolation.update(imu, {}, estimate, {0.0, 0.0}, state, core::kTickPeriod);
      }
      const bool seen = off == 0 && state == safety::FailsafeState::kNominal;
      const est::Contradiction<double> found = isolation.contradiction();
      EXPECT_EQ(found.check, seen ? est::ConsistencyCheck::kHeight : est::ConsistencyCheck::kNone);
      EXPECT_NEAR(found.measured, seen ? 4.0 : 0.0, 0.01);
      ASSERT_EQ(isolation.fence_motion(estimate).has_value(), seen);
      EXPECT_NEAR(isolation.fence_motion(estimate).value_or(estimate).height_m, seen ? 2.34 : 5.5, 0.01);
    }
  }
}

}  // namespace
}  // namespace m100::app
