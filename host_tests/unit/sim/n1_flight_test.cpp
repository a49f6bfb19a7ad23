// SPDX-License-Identifier: BSD-3-Clause
// The emulated autopilot in flight: movement, Virtual RC, tasks (protocol, sections 6 and 7).
#include "host_tests/unit/sim/n1_fixture.h"

#include <numbers>

namespace m100::sim {
namespace {

std::vector<std::byte> movement(std::uint8_t flag, float x, float y, float z, float yaw) {
  const auto value = encode(protocol::Movement{.flag = flag, .x = x, .y = y, .z = z, .yaw = yaw});
  return {value->bytes().begin(), value->bytes().end()};
}
std::vector<std::byte> sticks(std::uint32_t roll) {
  protocol::VirtualRcData data;
  data.channels.fill(1024);
  data.channels[0] = roll;
  data.channels[4] = 1324;
  const auto value = encode(data);
  return {value->bytes().begin(), value->bytes().end()};
}

TEST_F(N1Test, MovementWithoutControlIsIgnored) {
  activate();
  send(ids::kMovement, movement(0x0A, 10.F, 0.F, 0.F, 0.F));
  run(milliseconds(20));
  EXPECT_EQ(autopilot->record().movement_ignored, 1U);
  EXPECT_TRUE(std::holds_alternative<StickInput>(vehicle.last_input()));
}

TEST_F(N1Test, MovementIsFlownAndThenHoversWhenItStops) {
  obtain();
  send(ids::kMovement, movement(0x0A, 10.F, -20.F, 1.F, 30.F));
  run(milliseconds(20));
  const auto* flown = std::get_if<MovementInput>(&vehicle.last_input());
  ASSERT_NE(flown, nullptr);
  EXPECT_NEAR(flown->roll_rad, 0.17453, 1e-5);
  EXPECT_NEAR(flown->pitch_rad, 0.34907, 1e-5) << "nose up is positive on the wire and negative in FLU";
  EXPECT_NEAR(flown->climb_m_s, 1.0, 1e-6);
  EXPECT_NEAR(flown->yaw_rate_rad_s, -0.52360, 1e-5);
  run(seconds(1));
  const auto* hover = std::get_if<MovementInput>(&vehicle.last_input());
  ASSERT_NE(hover, nullptr) << "centred sticks would lean by the trim";
  EXPECT_EQ(hover->roll_rad, 0.0);
  EXPECT_EQ(hover->pitch_rad, 0.0);
  EXPECT_EQ(hover->climb_m_s, 0.0);
  EXPECT_EQ(hover->yaw_rate_rad_s, 0.0);
  EXPECT_TRUE(autopilot->client_in_control()) << "silence gives nothing back: no document says so";
}

TEST_F(N1Test, InControlWithoutAnyCommandItHovers) {
  obtain();
  run(milliseconds(20));
  const auto* hover = std::get_if<MovementInput>(&vehicle.last_input());
  ASSERT_NE(hover, nullptr);
  EXPECT_EQ(hover->roll_rad, 0.0);
}

TEST_F(N1Test, TheTransmitterHasControlFromTheReleaseOn) {
  activate();
  EXPECT_TRUE(autopilot->transmitter_in_control());
  obtain();
  EXPECT_FALSE(autopilot->transmitter_in_control());
  EXPECT_EQ(autopilot->transmitter_since(), core::TimePoint::max());
  send(ids::kVirtualRcSwitch, bytes({3}));
  ASSERT_EQ(code(ids::kControlRequest, bytes({0})), 4U);
  ASSERT_EQ(code(ids::kControlRequest, bytes({0})), 1U);
  EXPECT_FALSE(autopilot->transmitter_in_control()) << "virtual sticks still replace the pilot's";
  const core::TimePoint before = clock.now();
  send(ids::kVirtualRcSwitch, bytes({2}));
  run(milliseconds(20));
  EXPECT_TRUE(autopilot->transmitter_in_control());
  EXPECT_GE(autopilot->transmitter_since(), before);
  EXPECT_LE(autopilot->transmitter_since(), before + milliseconds(10));
}

struct Mode {
  const char* name;
  std::uint8_t flag;
  float x, y, z, yaw;
  MovementInput expected;
  std::uint8_t control_mode;
};
class N1Modes : public N1Test, public ::testing::WithParamInterface<Mode> {};
// The vehicle rests at 1.5 m with its nose 90 degrees to the left (west). Computed by hand: a speed error of 1 m/s
// commands 1 m/s^2, which is atan(1/9.8066) = 0.10162 rad.
INSTANTIATE_TEST_SUITE_P(
    N1, N1Modes,
    ::testing::Values(Mode{"AngleBodyYawRate", 0x0A, 5.7296F, 0.F, 0.F, 0.F, {0.1, 0.0, 0.0, 0.0}, 2},
                      Mode{"AngleGround", 0x08, 5.7296F, 0.F, 0.F, 0.F, {0.0, -0.1, 0.0, 0.0}, 2},
                      Mode{"VelocityBodyForward", 0x4A, 1.F, 0.F, 0.F, 0.F, {0.0, 0.10162, 0.0, 0.0}, 4},
                      Mode{"VelocityBodyRight", 0x4A, 0.F, 1.F, 0.F, 0.F, {0.10162, 0.0, 0.0, 0.0}, 4},
                      Mode{"VelocityGroundNorth", 0x48, 1.F, 0.F, 0.F, 0.F, {0.10162, 0.0, 0.0, 0.0}, 4},
                      Mode{"VelocityGroundEast", 0x48, 0.F, 1.F, 0.F, 0.F, {0.0, -0.10162, 0.0, 0.0}, 4},
                      Mode{"PositionBodyForward", 0x8A, 1.25F, 0.F, 0.F, 0.F, {0.0, 0.10162, 0.0, 0.0}, 6},
                      Mode{"HeightUp", 0x1A, 0.F, 0.F, 2.5F, 0.F, {0.0, 0.0, 1.0, 0.0}, 8},
                      Mode{"ThrustAboveHover", 0x2A, 0.F, 0.F, 43.F, 0.F, {0.0, 0.0, 1.0, 0.0}, 14},
                      Mode{"YawAngleWest", 0x02, 0.F, 0.F, 0.F, -90.F, {0.0, 0.0, 0.0, 0.0}, 1},
                      Mode{"YawAngleNorth", 0x02, 0.F, 0.F, 0.F, 0.F, {0.0, 0.0, 0.0, -1.74533}, 1}),
    [](const auto& tested) { return tested.param.name; });

TEST_P(N1Modes, AreFlownAsTiltClimbAndYawRate) {
  const Mode& mode = GetParam();
  vehicle.mutable_state().rotation_wb = core::quaternion_of(core::Euler<double>{.yaw_rad = std::numbers::pi / 2});
  obtain();
  fast_rates();
  send(ids::kMovement, movement(mode.flag, mode.x, mode.y, mode.z, mode.yaw));
  run(milliseconds(20));
  const auto* flown = std::get_if<MovementInput>(&vehicle.last_input());
  ASSERT_NE(flown, nullptr);
  EXPECT_NEAR(flown->roll_rad, mode.expected.roll_rad, 1e-5);
  EXPECT_NEAR(flown->pitch_rad, mode.expected.pitch_rad, 1e-5);
  EXPECT_NEAR(flown->climb_m_s, mode.expected.climb_m_s, 1e-5);
  EXPECT_NEAR(flown->yaw_rate_rad_s, mode.expected.yaw_rate_rad_s, 1e-5);
  EXPECT_EQ(last_control().control.mode, mode.control_mode);
}

TEST_F(N1Test, VirtualRcEndsOneSecondAfterItsLastData) {
  activate();
  fast_rates();
  send(ids::kVirtualRcSwitch, bytes({3}));
  send(ids::kVirtualRcData, sticks(1100));
  run(milliseconds(50));
  EXPECT_TRUE(autopilot->virtual_rc_on());
  EXPECT_EQ(std::get<StickInput>(vehicle.last_input()).roll_vrc, 1100.0);
  const protocol::Telemetry telemetry = last_control();
  EXPECT_TRUE(telemetry.control.virtual_rc_on());
  EXPECT_EQ(telemetry.rc.roll, 1152) << "(1100 - 1024) * 10000 / 660 = 1151.5";
  EXPECT_EQ(telemetry.rc.gear, -4545);
  EXPECT_EQ(telemetry.rc.mode, protocol::kRcModeA) << "channel 6 at 1024";
  run(milliseconds(850));
  EXPECT_TRUE(autopilot->virtual_rc_on());
  run(milliseconds(150));
  EXPECT_FALSE(autopilot->virtual_rc_on());
}

TEST_F(N1Test, ReservedBitsOfTheSwitchAreIgnored) {
  activate();
  send(ids::kVirtualRcSwitch, bytes({0xFF}));
  run(milliseconds(20));
  EXPECT_TRUE(autopilot->virtual_rc_on());
  send(ids::kVirtualRcSwitch, bytes({0xFE}));
  run(milliseconds(20));
  EXPECT_FALSE(autopilot->virtual_rc_on());
}

TEST_F(N1Test, SixtyFourBytesUnderTheSwitchIdAreNoSwitch) {
  activate();
  send(ids::kVirtualRcSwitch, sticks(1101));  // first byte odd: taken for "on" by a careless receiver
  run(milliseconds(20));
  EXPECT_FALSE(autopilot->virtual_rc_on());
}

TEST_F(N1Test, SwitchingOnTooOftenMakesItDeafToItsModeSwitch) {
  activate();
  send(ids::kVirtualRcSwitch, bytes({3}));
  run(milliseconds(500));
  send(ids::kVirtualRcSwitch, bytes({3}));
  run(milliseconds(50));
  autopilot->set_mode(N1Mode::kA);
  run(milliseconds(500));
  EXPECT_TRUE(autopilot->virtual_rc_on()) << "the hazard of the protocol's section 7";
  EXPECT_LT(autopilot->record().min_on_spacing, seconds(1));
}

TEST_F(N1Test, LeavingFEndsVirtualRc) {
  activate();
  send(ids::kVirtualRcSwitch, bytes({3}));
  run(milliseconds(50));
  autopilot->set_mode(N1Mode::kP);
  run(milliseconds(10));
  EXPECT_FALSE(autopilot->virtual_rc_on());
}

TEST_F(N1Test, TakeOffAndItsResult) {
  vehicle.mutable_state().in_air = false;
  vehicle.mutable_state().motors_on = false;
  vehicle.mutable_state().position_w_m.z() = 0.0;
  activate();
  EXPECT_EQ(code(ids::kTask, bytes({7, 4})), 1U) << "needs control";
  ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 3U);
  ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 2U);
  EXPECT_EQ(code(ids::kTask, bytes({7, 4})), 2U);
  EXPECT_TRUE(vehicle.state().motors_on);
  EXPECT_GT(std::get<MovementInput>(vehicle.last_input()).climb_m_s, 0.0);
  EXPECT_EQ(code(ids::kTaskQuery, bytes({7})), 3U);
  EXPECT_EQ(code(ids::kTaskQuery, bytes({8})), 1U);
  vehicle.mutable_state().position_w_m.z() = 1.3;
  EXPECT_EQ(code(ids::kTaskQuery, bytes({7})), 3U);
  EXPECT_EQ(code(ids::kTaskQuery, bytes({7})), 5U);
}

// Would catch an emulated autopilot that accepts a task which the reference says is refused.
TEST_F(N1Test, TakeOffIsRefusedWithMotorsOnAndLandingOnTheGround) {
  vehicle.mutable_state().in_air = false;
  vehicle.mutable_state().position_w_m.z() = 0.0;
  obtain();
  EXPECT_EQ(code(ids::kTask, bytes({1, 4})), 1U) << "motors on";
  EXPECT_EQ(code(ids::kTask, bytes({2, 6})), 1U) << "on the ground";
  vehicle.mutable_state().motors_on = false;
  autopilot->happen(N1EventKind::kTasks, 0.0);
  EXPECT_EQ(code(ids::kTask, bytes({3, 4})), 1U);
  autopilot->happen(N1EventKind::kTasks, 1.0);
  EXPECT_EQ(code(ids::kTask, bytes({4, 4})), 2U);
}

TEST_F(N1Test, ATaskEndsWithControl) {
  obtain();
  ASSERT_EQ(code(ids::kTask, bytes({1, 6})), 2U);
  EXPECT_LT(std::get<MovementInput>(vehicle.last_input()).climb_m_s, 0.0);
  ASSERT_EQ(code(ids::kControlRequest, bytes({0})), 4U);
  ASSERT_EQ(code(ids::kControlRequest, bytes({0})), 1U);
  run(milliseconds(20));
  EXPECT_TRUE(std::holds_alternative<StickInput>(vehicle.last_input())) << "the pilot's";
  EXPECT_EQ(code(ids::kTaskQuery, bytes({1})), 4U) << "failed";
}

TEST_F(N1Test, MotorsAreRefusedByName) {
  activate();
  EXPECT_EQ(code(ids::kMotors, bytes({0})), 1U);
  ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 3U);
  ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 2U);
  EXPECT_EQ(code(ids::kMotors, bytes({1})), 2U) << "already on";
  EXPECT_EQ(code(ids::kMotors, bytes({0})), 3U) << "in the air";
}

// A client may use one channel after the other, each at its own rate.
TEST_F(N1Test, EachChannelIsHeldToItsOwnRate) {
  obtain();
  int violations = 0;
  autopilot->on_event([&](const N1Event& event) { violations += event.name.starts_with("violation_") ? 1 : 0; });
  for (int i = 0; i < 50; ++i) {
    send(ids::kMovement, movement(0x0A, 0.F, 0.F, 0.F, 0.F));
    run(milliseconds(20));
  }
  send(ids::kVirtualRcSwitch, bytes({3}));
  for (int i = 0; i < 20; ++i) {
    send(ids::kVirtualRcData, sticks(1024));
    run(milliseconds(50));
  }
  EXPECT_EQ(violations, 0);
  for (int i = 0; i < 30; ++i) {
    send(ids::kVirtualRcData, sticks(1024));
    run(milliseconds(20));
  }
  EXPECT_GT(violations, 0);
}

// If Virtual RC times out, a client in control keeps its movement channel. Control that was given back does not count
// as lost.
TEST_F(N1Test, OnlyAChannelThatWasLostCountsAsCommandedAfterLoss) {
  obtain();
  send(ids::kVirtualRcSwitch, bytes({3}));
  run(milliseconds(1100));
  ASSERT_FALSE(autopilot->virtual_rc_on());
  ASSERT_EQ(autopilot->record().losses, 1U);
  send(ids::kMovement, movement(0x0A, 0.F, 0.F, 0.F, 0.F));
  run(milliseconds(20));
  EXPECT_EQ(autopilot->record().movement_taken, 1U);
  EXPECT_EQ(autopilot->record().control_after_loss, 0U);
  send(ids::kVirtualRcData, sticks(1024));
  run(milliseconds(20));
  EXPECT_EQ(autopilot->record().control_after_loss, 1U) << "this channel is gone";
  ASSERT_EQ(code(ids::kControlRequest, bytes({0})), 4U);
  ASSERT_EQ(code(ids::kControlRequest, bytes({0})), 1U);
  send(ids::kMovement, movement(0x0A, 0.F, 0.F, 0.F, 0.F));
  run(milliseconds(20));
  EXPECT_EQ(autopilot->record().movement_ignored, 1U);
  EXPECT_EQ(autopilot->record().control_after_loss, 1U);
}

TEST_F(N1Test, LandingIsFinishedForTwoSecondsAndThenStandby) {
  obtain();
  fast_rates();
  EXPECT_EQ(code(ids::kTask, bytes({1, 6})), 2U);
  EXPECT_EQ(last_control().flight_status, protocol::FlightStatus::kLanding);
  vehicle.mutable_state().position_w_m.z() = 0.0;
  vehicle.mutable_state().in_air = false;
  EXPECT_EQ(last_control().flight_status, protocol::FlightStatus::kLanded);
  EXPECT_FALSE(vehicle.state().motors_on);
  EXPECT_EQ(code(ids::kTaskQuery, bytes({1})), 5U);
  run(milliseconds(1800));
  EXPECT_EQ(last_control().flight_status, protocol::FlightStatus::kLanded);
  run(milliseconds(200));
  EXPECT_EQ(last_control().flight_status, protocol::FlightStatus::kStandby);
}

TEST_F(N1Test, ATaskThatThePilotEndsHasFailed) {
  obtain();
  ASSERT_EQ(code(ids::kTask, bytes({9, 6})), 2U);
  autopilot->set_mode(N1Mode::kA);
  run(milliseconds(20));
  EXPECT_EQ(code(ids::kTaskQuery, bytes({9})), 4U);
}

}  // namespace
}  // namespace m100::sim
