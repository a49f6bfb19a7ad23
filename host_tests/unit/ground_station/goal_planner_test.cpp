// SPDX-License-Identifier: BSD-3-Clause
// Goals that a room sends: which messages are accepted, and that the reference keeps its limits.
#include "firmware/companion/ground_station/goal_planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <string_view>

namespace m100::companion {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::uint16_t kOnlyPosition = 0b110111111000;
constexpr std::uint16_t kPositionAndYaw = 0b100111111000;
constexpr core::Duration kTick = core::kTickPeriod;

mavlink::SetPositionTargetLocalNed goal(float x, float y, float z, std::uint16_t mask = kOnlyPosition) {
  return {.x = x, .y = y, .z = z, .type_mask = mask, .coordinate_frame = 1};
}

struct GoalsTest : ::testing::Test {
  ref::Trajectory<double> trajectory;
  core::Fence fence{.side = {{{-5.0, 5.0}, {-5.0, 5.0}, {0.5, 4.0}}}};
  ref::SpeedLimits limits;
  std::unique_ptr<GoalPlanner<double>> goals;
  core::TimePoint now{seconds(10)};
  ref::Waypoint<double> start;

  void SetUp() override {
    start.position_w_m = {0.0, 0.0, 1.5};
    trajectory.hold(start);
    trajectory.start(now);
    goals = std::make_unique<GoalPlanner<double>>(trajectory, fence, limits);
  }
  struct At {
    double x, y, z, vx, vy, yaw;
  };
  At reference() const {
    const ref::Window<double> window = trajectory.window(now, core::Duration{0});
    return {window.x[0].position_m,   window.y[0].position_m,   window.height.position_m,
            window.x[0].velocity_m_s, window.y[0].velocity_m_s, window.yaw_rad};
  }
  /// Lets time pass and checks that every step of the reference keeps the limits.
  void pass(core::Duration time) {
    for (const core::TimePoint end = now + time; now < end;) {
      const At before = reference();
      now += kTick;
      const At after = reference();
      const double step = std::hypot(after.x - before.x, after.y - before.y, after.z - before.z);
      ASSERT_LE(step, 1.01 * limits.speed_m_s * 0.01) << "the reference jumped";
      const double turned = std::hypot(after.vx - before.vx, after.vy - before.vy);
      ASSERT_LE(turned, 1.01 * limits.acceleration_m_s2 * 0.01) << "the speed jumped";
    }
  }
};

TEST_F(GoalsTest, IsFlownToInNorthEastDown) {
  EXPECT_EQ(goals->take(goal(2.F, 1.F, -2.F), now, true), GoalResult::kAccepted);
  pass(seconds(8));
  EXPECT_NEAR(reference().x, 2.0, 1e-6);
  EXPECT_NEAR(reference().y, -1.0, 1e-6) << "east is our minus y";
  EXPECT_NEAR(reference().z, 2.0, 1e-6) << "down is our minus z";
  mavlink::SetPositionTargetLocalNed turned = goal(2.F, 1.F, -2.F, kPositionAndYaw);
  turned.yaw = 0.5F;
  EXPECT_EQ(goals->take(turned, now, true), GoalResult::kAccepted);
  pass(seconds(8));
  EXPECT_NEAR(reference().yaw, -0.5, 1e-6) << "clockwise from above is ours with a minus";
}

// Would catch a way that begins at the last goal instead of the present motion: the reference would jump.
TEST_F(GoalsTest, OneThatComesOnTheWayIsFlownToFromTheMotionOfThatMoment) {
  EXPECT_EQ(goals->take(goal(4.F, 0.F, -1.5F), now, true), GoalResult::kAccepted);
  pass(milliseconds(2000));
  EXPECT_GT(reference().vx, 0.5);
  EXPECT_EQ(goals->take(goal(0.F, 3.F, -1.5F), now, true), GoalResult::kAccepted);
  pass(seconds(10));
  EXPECT_NEAR(reference().x, 0.0, 1e-6);
  EXPECT_NEAR(reference().y, -3.0, 1e-6);
  EXPECT_EQ(goals->take(goal(4.F, 3.F, -1.5F), now, true), GoalResult::kAccepted);
  pass(milliseconds(1500));
  const double at_m = reference().x;
  EXPECT_TRUE(goals->hold(now, true));
  pass(seconds(3));
  EXPECT_GT(reference().x, at_m);
  EXPECT_LT(reference().x, at_m + limits.speed_m_s);
  EXPECT_EQ(reference().vx, 0.0);
}

// A moving target that is sent 20 times a second. Would catch a reference that stops at each place, and one that never
// gains speed because it starts anew each time.
TEST_F(GoalsTest, AStreamOfGoalsIsFollowedWithoutAStop) {
  constexpr double kSpeed_m_s = 0.8;
  for (int i = 0; i < 100; ++i) {
    const double at_m = kSpeed_m_s * 0.05 * i;
    const auto reported = static_cast<float>(at_m);
    ASSERT_EQ(goals->take(goal(reported, 0.F, -1.5F), now, true), GoalResult::kAccepted);
    pass(milliseconds(50));
    if (i > 40) {
      EXPECT_GT(reference().vx, 0.5) << "at " << 0.05 * i << " s";
      EXPECT_LT(std::abs(reference().x - at_m), 1.5) << "at " << 0.05 * i << " s";
    }
  }
  pass(seconds(6));
  EXPECT_NEAR(reference().x, kSpeed_m_s * 0.05 * 99, 1e-5);
}

TEST_F(GoalsTest, AWayThatWouldSwingBeyondTheFenceIsBrakedFirst) {
  EXPECT_EQ(goals->take(goal(5.F, 0.F, -1.5F), now, true), GoalResult::kAccepted);
  pass(milliseconds(3200));
  for (const float y : {3.F, -3.F, 4.F}) {
    EXPECT_EQ(goals->take(goal(4.9F, y, -1.5F), now, true), GoalResult::kAccepted);
    for (int i = 0; i < 400; ++i) {
      pass(core::kTickPeriod);
      ASSERT_LE(reference().x, 5.0 + 1e-6);
    }
  }
}

// A planner repeats its goal several times a second. Catches a reference that brakes for each repetition and never
// arrives.
TEST_F(GoalsTest, ARepeatedGoalIsOne) {
  EXPECT_EQ(goals->take(goal(2.F, 0.F, -1.5F), now, true), GoalResult::kAccepted);
  for (int i = 0; i < 100; ++i) {
    pass(milliseconds(50));
    EXPECT_EQ(goals->take(goal(2.F, 0.F, -1.5F), now, true), GoalResult::kUnchanged);
  }
  EXPECT_NEAR(reference().x, 2.0, 1e-6);
}

TEST_F(GoalsTest, StaysInsideTheFence) {
  EXPECT_EQ(goals->take(goal(900.F, 900.F, 900.F), now, true), GoalResult::kAccepted);
  EXPECT_LT((goals->cut_w_m() - core::Vector<double, 3>(895.0, 895.0, 900.5)).norm(), 1e-3)
      << "what the operator is told";
  pass(seconds(20));
  EXPECT_NEAR(reference().x, 5.0, 1e-6);
  EXPECT_NEAR(reference().y, -5.0, 1e-6);
  EXPECT_NEAR(reference().z, 0.5, 1e-6);
}

// Catches a yaw in degrees, which was wrapped and flown: 170 became a turn to 21 degrees. It also catches a limit of
// pi, which would refuse a heading from 0 to 360 degrees.
TEST_F(GoalsTest, AYawBeyondATurnIsRefusedAsAPosesAngleIs) {
  mavlink::SetPositionTargetLocalNed turned = goal(0.F, 0.F, -1.5F, kPositionAndYaw);
  for (const float yaw : {6.29F, -6.29F, 170.F, 1000.F, 1e9F}) {
    turned.yaw = yaw;
    EXPECT_EQ(goals->take(turned, now, true), GoalResult::kDegrees) << yaw;
    EXPECT_EQ(goals->refused_value(), static_cast<double>(yaw)) << "what the operator is told";
  }
  EXPECT_FALSE(goals->goal());
  for (const float yaw : {6.2831855F, 6.F, -6.2831855F}) {
    turned.yaw = yaw;
    EXPECT_EQ(goals->take(turned, now, true), GoalResult::kAccepted) << yaw;
  }
}

// Catches a height sent as upward: it was cut to the fence's lower side, and the aircraft sank there.
TEST_F(GoalsTest, AHeightWithTheWrongSignIsRefusedAndOneBelowTheFenceIsCut) {
  EXPECT_EQ(goals->take(goal(1.F, 0.F, 1.5F), now, true), GoalResult::kUpward);
  EXPECT_EQ(goals->refused_value(), 1.5);
  EXPECT_FALSE(goals->goal());
  EXPECT_EQ(goals->take(goal(1.F, 77.F, 1.5F, kOnlyPosition | 0b110), now, true), GoalResult::kAccepted) << "not named";
  EXPECT_EQ(goals->take(goal(2.F, 0.F, 0.2F), now, true), GoalResult::kAccepted) << "no height inside either way";
  EXPECT_NEAR(goals->cut_w_m().z(), 0.7, 1e-6);
  EXPECT_EQ(goals->refused_value(), 0.0);
}

TEST_F(GoalsTest, AHeadingAcrossTheRearIsReachedTheShortWay) {
  mavlink::SetPositionTargetLocalNed turned = goal(0.F, 0.F, -1.5F, kPositionAndYaw);
  for (const float yaw : {2.967F, -2.967F, 2.967F}) {
    turned.yaw = yaw;
    EXPECT_EQ(goals->take(turned, now, true), GoalResult::kAccepted);
    double turned_rad = 0.0;
    const double first_rad = reference().yaw;
    for (int i = 0; i < 800; ++i) {
      const double before_rad = reference().yaw;
      pass(kTick);
      turned_rad += std::abs(core::wrap_pi(reference().yaw - before_rad));
    }
    EXPECT_NEAR(core::wrap_pi(reference().yaw + static_cast<double>(yaw)), 0.0, 1e-6);
    EXPECT_NEAR(turned_rad, first_rad == 0.0 ? 2.967 : 2.0 * (core::kPi - 2.967), 1e-3) << yaw;
  }
}

TEST_F(GoalsTest, AnIgnoredAxisStaysWhereItIs) {
  EXPECT_EQ(goals->take(goal(1.F, 77.F, 77.F, kOnlyPosition | 0b110), now, true), GoalResult::kAccepted);
  pass(seconds(8));
  EXPECT_NEAR(reference().x, 1.0, 1e-6);
  EXPECT_NEAR(reference().y, 0.0, 1e-6);
  EXPECT_NEAR(reference().z, 1.5, 1e-6);
}

// Catches a stop that brakes harder than the limit, as it did by 39 % if the aircraft accelerated when it began.
TEST_F(GoalsTest, RandomGoalsAndStopsKeepTheLimits) {
  std::mt19937 random(7);
  const auto below = [&random](unsigned most) { return static_cast<float>(random() % (1000UL * most)) / 1000.F; };
  for (int i = 0; i < 1000; ++i) {
    if (below(1) < 0.3F) {
      EXPECT_TRUE(goals->hold(now, true));
    } else {
      EXPECT_EQ(goals->take(goal(below(10) - 5.F, below(10) - 5.F, -below(5)), now, true), GoalResult::kAccepted);
    }
    pass(kTick * static_cast<int>(1.F + below(200)));
  }
}

TEST_F(GoalsTest, WhatIsNoGoalMovesNothing) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(goals->take(goal(1.F, 0.F, -1.F), now, false), GoalResult::kNotFlying);
  EXPECT_EQ(goals->take(goal(kNan, 0.F, -1.F), now, true), GoalResult::kNotFinite);
  EXPECT_EQ(goals->take(goal(2000.F, 0.F, -1.F), now, true), GoalResult::kNotFinite);
  EXPECT_EQ(goals->take(goal(1.F, 0.F, -1.F, 0), now, true), GoalResult::kMask) << "velocities are asked for, too";
  EXPECT_EQ(goals->take(goal(1.F, 0.F, -1.F, kOnlyPosition | 0b111), now, true), GoalResult::kMask)
      << "nothing is asked";
  EXPECT_EQ(goals->take(goal(1.F, 0.F, -1.F, kOnlyPosition | 1U << 9U), now, true), GoalResult::kMask) << "a force";
  mavlink::SetPositionTargetLocalNed body = goal(1.F, 0.F, -1.F);
  body.coordinate_frame = 8;
  EXPECT_EQ(goals->take(body, now, true), GoalResult::kFrame);
  mavlink::SetPositionTargetLocalNed turned = goal(1.F, 0.F, -1.F, kPositionAndYaw);
  turned.yaw = kNan;
  EXPECT_EQ(goals->take(turned, now, true), GoalResult::kNotFinite);
  EXPECT_FALSE(goals->hold(now, false));
  EXPECT_FALSE(goals->goal());
  pass(seconds(2));
  EXPECT_EQ(reference().x, 0.0);
}

// Would catch a goal that outlives its flight: the next flight would begin with a way from an old place.
TEST_F(GoalsTest, AFlightThatBeginsAnewHoldsItsPlace) {
  est::Estimate<double> estimate;
  estimate.x.position_m = -1.0;
  estimate.y.position_m = 2.0;
  estimate.height_m = 1.2;
  goals->update(now, true, now, estimate);
  EXPECT_EQ(reference().x, 0.0) << "the course that it began with is left alone";
  EXPECT_EQ(goals->take(goal(3.F, 0.F, -1.5F), now, true), GoalResult::kAccepted);
  goals->update(now, true, now, estimate);
  pass(seconds(1));
  EXPECT_GT(reference().x, 0.01);
  now += seconds(1);
  goals->update(now, true, now, estimate);
  EXPECT_EQ(reference().x, -1.0);
  EXPECT_EQ(reference().y, 2.0);
  EXPECT_EQ(reference().z, 1.2);
}

// The operator reads these names in the answer to a goal: each answer must have one, and no two the same.
TEST(GoalAnswers, EachHasAnotherName) {
  std::set<std::string_view> names;
  for (const GoalResult answer :
       {GoalResult::kAccepted, GoalResult::kUnchanged, GoalResult::kNotFlying, GoalResult::kFrame, GoalResult::kMask,
        GoalResult::kNotFinite, GoalResult::kDegrees, GoalResult::kUpward, GoalResult::kReturningToStart}) {
    EXPECT_GT(name(answer).size(), 8U) << name(answer);
    names.insert(name(answer));
  }
  EXPECT_EQ(names.size(), 9U);
}

}  // namespace
}  // namespace m100::companion
