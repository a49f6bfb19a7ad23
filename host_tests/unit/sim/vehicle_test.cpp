// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/vehicle.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>

namespace m100::sim {
namespace {

using core::Vector;
using std::chrono::milliseconds;

Plant still_plant() {
  Plant plant = measured_plant();
  plant.air.attitude_disturbance_rad = 0.0;
  plant.air.climb_disturbance_m_s = 0.0;
  plant.air.yaw_rate_disturbance_rad_s = 0.0;
  return plant;
}

constexpr StickInput kBalanced{.roll_vrc = 1080.0, .pitch_vrc = 998.0};  // paper, III-B.3

void fly(Vehicle& vehicle, int ticks) {
  for (int i = 0; i < ticks; ++i) {
    vehicle.advance(milliseconds(10));
  }
}

TEST(Vehicle, StaysWhereItIsWithBalancedSticks) {
  RecordProperty("paper", "III-B.3");
  Vehicle vehicle(still_plant(), 1, Vector<double, 3>(1.0, 2.0, 3.0));
  vehicle.command(kBalanced);
  fly(vehicle, 1000);
  EXPECT_NEAR((vehicle.state().position_w_m - Vector<double, 3>(1.0, 2.0, 3.0)).norm(), 0.0, 1e-9);
}

TEST(Vehicle, DriftsWithCentredSticksBecauseOfItsTrim) {
  Vehicle vehicle(still_plant(), 1, Vector<double, 3>(0.0, 0.0, 3.0));
  vehicle.command(StickInput{});
  fly(vehicle, 200);
  EXPECT_GT(vehicle.state().position_w_m.y(), 0.3);  // roll stick 56 counts left of its balance
  EXPECT_GT(vehicle.state().position_w_m.x(), 0.1);  // pitch stick 26 counts forward of its balance
}

struct Push {
  const char* name;
  StickInput sticks;
  double yaw_rad;
  Vector<double, 3> towards;
};
class Directions : public ::testing::TestWithParam<Push> {};

// World NWU, body FLU; sticks right, forward, up positive (paper, III-A).
TEST_P(Directions, StickMovesTheAircraftThere) {
  Vehicle vehicle(still_plant(), 1, Vector<double, 3>(0.0, 0.0, 5.0), GetParam().yaw_rad);
  vehicle.command(GetParam().sticks);
  fly(vehicle, 100);
  const Vector<double, 3> velocity = vehicle.state().velocity_w_m_s;
  EXPECT_GT(velocity.dot(GetParam().towards), 0.3);
  EXPECT_LT((velocity - GetParam().towards * velocity.dot(GetParam().towards)).norm(), 0.02);
}
INSTANTIATE_TEST_SUITE_P(
    Table, Directions,
    ::testing::Values(Push{"RightIsMinusY", {.roll_vrc = 1180.0, .pitch_vrc = 998.0}, 0.0, {0.0, -1.0, 0.0}},
                      Push{"ForwardIsPlusX", {.roll_vrc = 1080.0, .pitch_vrc = 1098.0}, 0.0, {1.0, 0.0, 0.0}},
                      Push{"ForwardAtQuarterTurnIsPlusY",
                           {.roll_vrc = 1080.0, .pitch_vrc = 1098.0},
                           core::kPi / 2.0,
                           {0.0, 1.0, 0.0}},
                      Push{"UpIsUp", {.roll_vrc = 1080.0, .pitch_vrc = 998.0, .throttle_vrc = 1224.0}, 0.0, {0, 0, 1}}),
    [](const auto& tested) { return tested.param.name; });

TEST(Vehicle, AcceleratesByGravityTimesTangentOfTilt) {
  Plant plant = still_plant();
  plant.air.linear_drag_per_s = 0.0;
  Vehicle vehicle(plant, 1, Vector<double, 3>(0.0, 0.0, 50.0));
  vehicle.command(StickInput{.roll_vrc = 1080.0, .pitch_vrc = 998.0 + 217.5});
  fly(vehicle, 200);
  const double before = vehicle.state().velocity_w_m_s.x();
  fly(vehicle, 100);
  EXPECT_NEAR(vehicle.state().velocity_w_m_s.x() - before, model::kGravity_m_s2 * std::tan((217.5 - 18.45) * 9.22e-4),
              1e-3);
  EXPECT_NEAR(vehicle.state().position_w_m.z(), 50.0, 1e-6);  // thrust is compensated (paper, III-B.2)
}

TEST(Vehicle, TurnsRightWithTheYawStick) {
  Vehicle vehicle(still_plant(), 1, Vector<double, 3>(0.0, 0.0, 5.0));
  vehicle.command(StickInput{.roll_vrc = 1080.0, .pitch_vrc = 998.0, .yaw_vrc = 1124.0});
  fly(vehicle, 100);
  EXPECT_LT(vehicle.attitude().yaw_rad, -0.05);
  EXPECT_LT(vehicle.state().rate_b_rad_s.z(), -0.1);
}

TEST(Vehicle, IsAtRestForItsAccelerometer) {
  Vehicle vehicle(still_plant(), 1, Vector<double, 3>(0.0, 0.0, 5.0));
  vehicle.command(kBalanced);
  fly(vehicle, 10);
  EXPECT_NEAR((vehicle.state().specific_force_b_m_s2 - Vector<double, 3>(0.0, 0.0, 9.8066)).norm(), 0.0, 1e-9);
}

TEST(Vehicle, IsPushedByTheFanAsThePaperSaysAndNoMore) {
  RecordProperty("paper", "IV-D.2");
  Plant plant = with_fan(still_plant());
  plant.air.turbulence_m_s = 0.0;
  plant.air.yaw_rate_disturbance_rad_s = 0.0;
  Vehicle vehicle(plant, 1, Vector<double, 3>(0.0, 0.0, 5.0));
  vehicle.command(kBalanced);
  fly(vehicle, 100);
  EXPECT_NEAR(vehicle.state().velocity_w_m_s.norm(), 0.162, 0.005);  // m/s after 1 s, see Air::linear_drag_per_s
  EXPECT_NEAR(vehicle.state().velocity_w_m_s.y() / vehicle.state().velocity_w_m_s.x(), 0.930 / 0.175, 0.02);
}

/// Largest turn from the start in ten minutes with resting sticks, and the root mean square of the turn rate.
std::array<double, 2> turned(const Plant& plant) {
  Vehicle vehicle(plant, 1, Vector<double, 3>(0.0, 0.0, 5.0));
  vehicle.command(kBalanced);
  double farthest_rad = 0.0, squares = 0.0;
  for (int tick = 0; tick < 60000; ++tick) {
    fly(vehicle, 1);
    farthest_rad = std::max(farthest_rad, std::abs(vehicle.attitude().yaw_rad));
    squares += vehicle.state().rate_b_rad_s.z() * vehicle.state().rate_b_rad_s.z();
  }
  return {farthest_rad, std::sqrt(squares / 60000.0)};
}

// A held heading comes back; a turn inside the integral is a random walk of sigma sqrt(2 time 0.25 s), 0.52 rad here.
TEST(Vehicle, IntegratesATurnOfTheAirAndHoldsAWanderingHeading) {
  Plant held = still_plant(), integrated = still_plant();
  held.air.yaw_rate_disturbance_rad_s = integrated.air.turn_disturbance_rad_s = 0.03;
  const std::array<double, 2> wanders = turned(held), walks = turned(integrated);
  EXPECT_LT(wanders[0], 0.04);
  EXPECT_GT(walks[0], 0.2);
  EXPECT_NEAR(wanders[1], 0.03, 0.004);
  EXPECT_NEAR(walks[1], 0.03, 0.004);
}

// Its random numbers are a stream of their own. Catches a turn that moves the roll of a world with the same seed.
TEST(Vehicle, RollsTheSameWithAndWithoutATurnOfTheAir) {
  Plant turning = measured_plant();
  turning.air.turn_disturbance_rad_s = 0.03;
  Vehicle with(turning, 1, Vector<double, 3>(0.0, 0.0, 5.0)),
      without(measured_plant(), 1, Vector<double, 3>(0.0, 0.0, 5.0));
  fly(with, 100);
  fly(without, 100);
  EXPECT_EQ(with.attitude().roll_rad, without.attitude().roll_rad);
  EXPECT_NE(with.attitude().yaw_rad, without.attitude().yaw_rad);
}

// On the ground the specific force is gravity's, whatever the throttle stick commands.
TEST(Vehicle, ShowsItsWeightOnTheGround) {
  Vehicle vehicle(still_plant(), 1, Vector<double, 3>(0.0, 0.0, 0.3));
  vehicle.command(StickInput{.roll_vrc = 1080.0, .pitch_vrc = 998.0, .throttle_vrc = 824.0});
  fly(vehicle, 300);
  ASSERT_FALSE(vehicle.state().in_air);
  EXPECT_NEAR(vehicle.state().specific_force_b_m_s2.norm(), 9.8066, 1e-6);
}

// The disturbance by the air must not lift an aircraft whose motors are off.
TEST(Vehicle, StaysOnTheGroundWithItsMotorsOff) {
  Vehicle vehicle(measured_plant(), 3, Vector<double, 3>(0.0, 0.0, 0.0));
  vehicle.set_motors(false);
  vehicle.command(kBalanced);
  for (int i = 0; i < 2000; ++i) {
    vehicle.advance(milliseconds(10));
    ASSERT_FALSE(vehicle.state().in_air);
  }
}

// A slung load swings at sqrt(g / L (1 + m / M)) and takes the aircraft along.
TEST(Vehicle, SwingsWithASlungLoad) {
  Plant plant = still_plant();
  plant.payload = {.mass_kg = 1.0, .slung_length_m = 2.0};
  Vehicle vehicle(plant, 1, Vector<double, 3>(0.0, 0.0, 20.0));
  vehicle.command(StickInput{.roll_vrc = 1080.0, .pitch_vrc = 1198.0});
  fly(vehicle, 50);
  vehicle.command(kBalanced);
  fly(vehicle, 100);
  double before = 0.0;
  int turns = 0;
  for (int i = 0; i < 1000; ++i) {
    const double speed = vehicle.state().velocity_w_m_s.x();
    vehicle.advance(milliseconds(10));
    const double acceleration = vehicle.state().velocity_w_m_s.x() - speed;
    turns += acceleration * before < 0.0 ? 1 : 0;
    before = acceleration;
  }
  const double expected = 10.0 * std::sqrt(9.8066 / 2.0 * (1.0 + 1.0 / 3.3)) / core::kPi;
  EXPECT_NEAR(turns, expected, 1.5);
}

TEST(Vehicle, IsTheSameFlightForTheSameSeed) {
  Plant plant = with_fan(measured_plant());
  Vehicle one(plant, 7, Vector<double, 3>(0.0, 0.0, 5.0));
  Vehicle two(plant, 7, Vector<double, 3>(0.0, 0.0, 5.0));
  Vehicle other(plant, 8, Vector<double, 3>(0.0, 0.0, 5.0));
  for (Vehicle* vehicle : {&one, &two, &other}) {
    vehicle->command(kBalanced);
    fly(*vehicle, 300);
  }
  EXPECT_EQ(one.state().position_w_m, two.state().position_w_m);
  EXPECT_NE(one.state().position_w_m, other.state().position_w_m);
}

// The noise floors measured in pitch_roll.csv and height.csv, see Air.
TEST(Vehicle, WandersAsMuchAsTheMeasuredAircraftAtRest) {
  Vehicle vehicle(measured_plant(), 3, Vector<double, 3>(0.0, 0.0, 500.0));
  vehicle.command(kBalanced);
  double roll2 = 0.0;
  double rate2 = 0.0;
  constexpr int kTicks = 20000;
  for (int i = 0; i < kTicks; ++i) {
    vehicle.advance(milliseconds(10));
    roll2 += vehicle.attitude().roll_rad * vehicle.attitude().roll_rad;
    rate2 += vehicle.state().rate_b_rad_s.z() * vehicle.state().rate_b_rad_s.z();
  }
  EXPECT_NEAR(std::sqrt(roll2 / kTicks), 0.004, 0.0008);
  EXPECT_NEAR(std::sqrt(rate2 / kTicks), 0.02, 0.004);
}

TEST(Vehicle, HasAnotherDragAlongItsHeadingThanAcross) {
  Plant plant = still_plant();
  plant.air.linear_drag_per_s = 0.0;
  plant.air.body_drag_x_per_s = 0.5;
  plant.air.body_drag_y_per_s = 0.2;
  plant.air.wind_m_s = {3.0, 4.0, 0.0};
  Vehicle vehicle(plant, 1, Vector<double, 3>(0.0, 0.0, 5.0), core::kPi / 2.0);  // body x points along world y
  vehicle.command(kBalanced);
  vehicle.advance(milliseconds(10));
  EXPECT_NEAR(vehicle.state().velocity_w_m_s.x(), 0.01 * 0.2 * 3.0, 1e-4);
  EXPECT_NEAR(vehicle.state().velocity_w_m_s.y(), 0.01 * 0.5 * 4.0, 1e-4);
}

TEST(Vehicle, PicksItsPayloadUpOnRequestAndSags) {
  Plant plant = still_plant();
  plant.payload = {.mass_kg = 1.0, .picked_up_at_s = 2.0};
  Vehicle vehicle(plant, 1, Vector<double, 3>(0.0, 0.0, 5.0));
  vehicle.command(kBalanced);
  fly(vehicle, 199);
  EXPECT_NEAR(vehicle.state().position_w_m.z(), 5.0, 1e-9);
  fly(vehicle, 201);
  // g m / (M + m) acts for the 0.1 s of the height loop, and the speed is regained within 0.3 s: 0.228 m/s times 0.3 s.
  EXPECT_NEAR(vehicle.state().position_w_m.z(), 5.0 - 0.0684, 0.002);
}

TEST(Vehicle, ChangesInMidFlightAndGoesOnFromWhereItIs) {
  Plant plant = still_plant();
  plant.change.at_s = 1.0;
  plant.change.steps.push_back([](Plant& changes) { changes.roll.scale_per_count *= 0.5; });
  plant.change.steps.push_back([](Plant& changes) { changes.air.wind_m_s = {0.0, 8.0, 0.0}; });
  Vehicle vehicle(plant, 1, Vector<double, 3>(0.0, 0.0, 50.0));
  vehicle.command(StickInput{.roll_vrc = 1180.0, .pitch_vrc = 998.0});
  fly(vehicle, 100);
  const double before_rad = vehicle.attitude().roll_rad;
  vehicle.advance(milliseconds(1));
  EXPECT_NEAR(vehicle.attitude().roll_rad, before_rad, 0.01 * before_rad);
  fly(vehicle, 200);
  EXPECT_NEAR(vehicle.attitude().roll_rad, 0.5 * before_rad, 0.02 * before_rad);
}

TEST(Vehicle, IsLiftedByItsOwnAirNearTheGround) {
  Plant plant = still_plant();
  plant.air.ground_effect = 1.0;
  Vehicle low(plant, 1, Vector<double, 3>(0.0, 0.0, 0.1));
  Vehicle high(plant, 1, Vector<double, 3>(0.0, 0.0, 3.0));
  for (Vehicle* const vehicle : {&low, &high}) {
    vehicle->command(kBalanced);
    fly(*vehicle, 100);
  }
  EXPECT_GT(low.state().position_w_m.z(), 0.11);
  EXPECT_NEAR(high.state().position_w_m.z(), 3.0, 0.001);
}

}  // namespace
}  // namespace m100::sim
