// SPDX-License-Identifier: BSD-3-Clause
// The emulated autopilot, command by command, as a client's raw frames see it (protocol, sections 4 to 8 and 11).
#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "host_tests/sim/n1_autopilot.h"
#include "host_tests/sim/still_vehicle.h"
#include "protocol/acks.h"
#include "protocol/aes256.h"
#include "protocol/frame_encoder.h"

namespace m100::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
namespace ids = protocol::ids;

std::vector<std::byte> bytes(std::initializer_list<unsigned> values) {
  std::vector<std::byte> result;
  for (const unsigned value : values) {
    result.push_back(static_cast<std::byte>(value));
  }
  return result;
}

struct Heard {
  protocol::FrameHeader header;
  protocol::MessageId id;
  std::vector<std::byte> value;
};

struct N1Test : ::testing::Test {
  void start(const N1Config& config) { autopilot.emplace(cable.b(), vehicle, config); }
  void SetUp() override { start({}); }

  /// Sends a command in a session, waits, and returns the value of its acknowledgement.
  std::optional<std::vector<std::byte>> ask(protocol::MessageId id, const std::vector<std::byte>& value,
                                            std::uint8_t session = 2, const protocol::Cipher* cipher = nullptr) {
    ++sequence;
    return ask_again(id, value, session, cipher);
  }
  std::optional<std::vector<std::byte>> ask_again(protocol::MessageId id, const std::vector<std::byte>& value,
                                                  std::uint8_t session = 2, const protocol::Cipher* cipher = nullptr) {
    send(id, value, session, cipher);
    heard.clear();
    run(milliseconds(30));
    for (const Heard& frame : heard) {
      if (frame.header.is_ack && frame.header.session == session && frame.header.sequence == sequence) {
        return frame.value;
      }
    }
    return std::nullopt;
  }
  unsigned code(protocol::MessageId id, const std::vector<std::byte>& value) {
    const auto answer = ask(id, value);
    EXPECT_TRUE(answer && answer->size() == 2U) << "acknowledgements are two bytes";
    return answer && answer->size() == 2
               ? std::to_integer<unsigned>((*answer)[0]) | std::to_integer<unsigned>((*answer)[1]) << 8U
               : 0xDEADU;
  }
  void send(protocol::MessageId id, const std::vector<std::byte>& value, std::uint8_t session = 0,
            const protocol::Cipher* cipher = nullptr) {
    std::array<std::byte, 256> space;
    const auto frame = protocol::encode_frame(
        {.session = session, .is_ack = false, .encrypted = cipher != nullptr, .sequence = sequence}, &id, value, space,
        cipher);
    ASSERT_TRUE(frame.has_value());
    ASSERT_TRUE(cable.a().write(*frame).has_value());
  }
  void run(core::Duration time) {
    for (const core::TimePoint end = clock.now() + time; clock.now() < end;) {
      clock.advance(N1Autopilot::kTick);
      autopilot->advance(clock.now());
      std::array<std::byte, 512> buffer;
      const std::size_t count = cable.a().read(buffer).value();
      parser.consume(std::span(buffer).first(count), [&](const protocol::FrameView& frame) {
        protocol::CipherScratch scratch;
        const auto message = protocol::open(frame, cipher_of_client, scratch);
        ASSERT_TRUE(message.has_value());
        heard.push_back({message->header, message->id, {message->value.begin(), message->value.end()}});
      });
    }
  }
  void activate() {
    std::vector<std::byte> value(44);
    value[4] = std::byte{2};
    value[9] = std::byte{0x0A};
    value[10] = std::byte{0x01};
    value[11] = std::byte{0x03};
    ASSERT_EQ(code(ids::kActivation, value), 0U);
  }
  void obtain() {
    activate();
    ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 3U);
    ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 2U);
  }
  std::size_t pushes(protocol::MessageId id) const {
    std::size_t count = 0;
    for (const Heard& frame : heard) {
      count += !frame.header.is_ack && frame.id == id && frame.header.session == 0 ? 1U : 0U;
    }
    return count;
  }
  protocol::Telemetry last_control() {
    heard.clear();
    run(milliseconds(40));
    protocol::Telemetry telemetry;
    for (const Heard& frame : heard) {
      if (frame.id == ids::kTelemetry && !frame.header.is_ack) {
        EXPECT_EQ(protocol::decode_telemetry(frame.value, telemetry), core::Status::kOk);
      }
    }
    return telemetry;
  }
  void fast_rates() {
    ASSERT_EQ(code(ids::kTelemetryFrequency, bytes({3, 3, 3, 3, 3, 3, 0, 3, 0, 3, 3, 3, 0, 0, 0, 0})), 0U);
  }

  hal::ManualClock clock;
  hal::UartPair cable{clock, 230400};
  StillVehicle vehicle;
  std::optional<N1Autopilot> autopilot;
  protocol::FrameParser parser;
  std::vector<Heard> heard;
  std::uint16_t sequence = 100;
  const protocol::Cipher* cipher_of_client = nullptr;
};

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

TEST_F(N1Test, TelemetryStreamsBeforeActivationAtTheAssistantsRates) {
  run(seconds(2));
  EXPECT_EQ(pushes(ids::kTelemetry), 100U);
}

TEST_F(N1Test, ItemsComeAtTheRatesAskedFor) {
  ASSERT_EQ(code(ids::kTelemetryFrequency, bytes({4, 4, 0, 3, 0, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0, 0})), 0U);
  heard.clear();
  run(seconds(4));
  std::array<std::size_t, 12> counts{};
  for (const Heard& frame : heard) {
    const auto items = protocol::load<std::uint16_t>(frame.value.data());
    for (std::size_t item = 0; item < counts.size(); ++item) {
      counts[item] += items >> item & 1U;
    }
  }
  EXPECT_EQ(counts, (std::array<std::size_t, 12>{400, 400, 0, 200, 0, 0, 0, 40, 0, 0, 4, 200}));
}

TEST_F(N1Test, FrequencyCode5LeavesAndCode6IsAnError) {
  fast_rates();
  EXPECT_EQ(code(ids::kTelemetryFrequency, bytes({5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 0, 0, 0, 0})), 0U);
  heard.clear();
  run(seconds(1));
  EXPECT_EQ(pushes(ids::kTelemetry), 50U);
  EXPECT_EQ(code(ids::kTelemetryFrequency, bytes({6, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0})), 1U);
}

TEST_F(N1Test, TheVersionIsAnsweredInAnyStateIn49Bytes) {
  const auto before = ask(ids::kVersionQuery, bytes({0}));
  ASSERT_TRUE(before && before->size() == 49U);
  const auto answer = protocol::decode_version_answer(*before);
  EXPECT_EQ(answer->code, 0xFF01);
  EXPECT_EQ(protocol::text(answer->version_name), "SDK-v1.0 BETA M100-03.01.01.00");
  EXPECT_EQ(protocol::sdk_version(*answer).value(), 0x03010A00U);
  for (std::size_t i = 2; i < 6; ++i) {
    EXPECT_NE((*before)[i], std::byte{0}) << "SDK 3.2.1 loses its place at a zero in the CRC";
  }
  activate();
  EXPECT_EQ(protocol::decode_version_answer(*ask(ids::kVersionQuery, bytes({0})))->code, 0);
}

TEST_F(N1Test, ActivationWithAnotherVersionIsRefusedByCode) {
  EXPECT_EQ(code(ids::kActivation, std::vector<std::byte>(44)), protocol::activation_ack::kVersionMismatch);
  EXPECT_FALSE(autopilot->activated());
}

TEST_F(N1Test, NothingOfSet1BeforeActivation) {
  EXPECT_EQ(code(ids::kControlRequest, bytes({1})), 0xFF01U);
  EXPECT_EQ(code(ids::kMotors, bytes({1})), 0xFF01U);
  send(ids::kVirtualRcSwitch, bytes({3}));
  run(milliseconds(20));
  EXPECT_FALSE(autopilot->virtual_rc_on());
}

TEST_F(N1Test, ARepeatedFrameIsAnsweredFromStoreAndNotExecutedAgain) {
  activate();
  ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 3U);
  // The identical frame once more: executed twice it would obtain.
  const auto stored = ask_again(ids::kControlRequest, bytes({1}));
  ASSERT_TRUE(stored.has_value());
  EXPECT_EQ((*stored)[0], std::byte{3});
  EXPECT_FALSE(autopilot->client_in_control());
  EXPECT_EQ(autopilot->record().obtain_requests, 1U);
}

TEST_F(N1Test, ControlIsAskedForAndGivenBackTwice) {
  obtain();
  EXPECT_TRUE(autopilot->client_in_control());
  fast_rates();
  EXPECT_EQ(last_control().control.device(), protocol::ControlDevice::kOnboardComputer);
  EXPECT_EQ(code(ids::kControlRequest, bytes({0})), 4U);
  EXPECT_EQ(code(ids::kControlRequest, bytes({0})), 1U);
  EXPECT_FALSE(autopilot->client_in_control());
}

TEST_F(N1Test, LeavingFDropsControlAndPushesInSession0AndReturningDoesNotRestoreIt) {
  obtain();
  heard.clear();
  autopilot->set_mode(N1Mode::kA);
  run(milliseconds(20));
  EXPECT_EQ(pushes(ids::kControlLost), 1U);
  EXPECT_FALSE(autopilot->client_in_control());
  EXPECT_EQ(code(ids::kControlRequest, bytes({1})), 0U);
  autopilot->set_mode(N1Mode::kF);
  run(seconds(1));
  EXPECT_FALSE(autopilot->client_in_control());
}

TEST_F(N1Test, IocAndTheMobileAppHaveTheirOwnAnswers) {
  activate();
  autopilot->happen(N1Happening::kIoc, 1);
  EXPECT_EQ(code(ids::kControlRequest, bytes({1})), 0xC9U);
  autopilot->happen(N1Happening::kIoc, 0);
  autopilot->happen(N1Happening::kTake, 'm');
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(code(ids::kControlRequest, bytes({1})), 3U);
  }
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
  EXPECT_TRUE(std::holds_alternative<StickInput>(vehicle.last_input()));
}

struct Mode {
  const char* name;
  std::uint8_t flag;
  float x, y, z, yaw;
  MovementInput expected;
  std::uint8_t control_mode;
};
class N1Modes : public N1Test, public ::testing::WithParamInterface<Mode> {};
// The vehicle rests at 1.5 m with its nose 90 degrees to the left (west). Hand-made: 1 m/s of error is 1 m/s^2 is
// atan(1/9.8066) = 0.10162 rad.
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
  start({.lenient_virtual_rc = true});
  parser = {};
  activate();
  send(ids::kVirtualRcSwitch, bytes({3}));
  send(ids::kVirtualRcSwitch, sticks(1101));
  run(milliseconds(50));
  EXPECT_EQ(std::get<StickInput>(vehicle.last_input()).roll_vrc, 1101.0);
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
  EXPECT_LT(autopilot->record().least_on_spacing, seconds(1));
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
  EXPECT_GT(std::get<StickInput>(vehicle.last_input()).throttle_vrc, 1024.0);
  EXPECT_EQ(code(ids::kTaskQuery, bytes({7})), 3U);
  EXPECT_EQ(code(ids::kTaskQuery, bytes({8})), 1U);
  vehicle.mutable_state().position_w_m.z() = 1.3;
  EXPECT_EQ(code(ids::kTaskQuery, bytes({7})), 3U);
  EXPECT_EQ(code(ids::kTaskQuery, bytes({7})), 5U);
}

TEST_F(N1Test, MotorsAreRefusedByName) {
  activate();
  EXPECT_EQ(code(ids::kMotors, bytes({0})), 1U);
  ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 3U);
  ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 2U);
  EXPECT_EQ(code(ids::kMotors, bytes({1})), 2U) << "already on";
  EXPECT_EQ(code(ids::kMotors, bytes({0})), 3U) << "in the air";
}

TEST_F(N1Test, EncryptedCommandsAreAnsweredEncryptedAndAWrongKeyByItsCode) {
  const protocol::Aes256 right(protocol::CipherKey{1, 2, 3});
  start({.cipher = &right});
  activate();
  cipher_of_client = &right;
  const auto answer = ask(ids::kControlRequest, bytes({1}), 3, &right);
  ASSERT_TRUE(answer && answer->size() == 2U);
  EXPECT_EQ((*answer)[0], std::byte{3});
  bool encrypted = false;
  for (const Heard& frame : heard) {
    encrypted = encrypted || (frame.header.is_ack && frame.header.encrypted());
  }
  EXPECT_TRUE(encrypted);
  const protocol::Aes256 wrong(protocol::CipherKey{9});
  const auto refused = ask(ids::kControlRequest, bytes({1}), 3, &wrong);
  ASSERT_TRUE(refused && refused->size() == 2U);
  EXPECT_EQ((*refused)[1], std::byte{0xFF});
}

TEST_F(N1Test, ARestartForgetsEverything) {
  obtain();
  autopilot->happen(N1Happening::kRestart);
  run(milliseconds(10));  // what was on the line
  heard.clear();
  run(seconds(1));
  EXPECT_TRUE(heard.empty()) << "booting";
  run(seconds(2));
  EXPECT_GT(pushes(ids::kTelemetry), 0U);
  EXPECT_EQ(code(ids::kControlRequest, bytes({1})), 0xFF01U);
}

TEST(N1Script, IsReadLineByLineAndErrorsNameTheLine) {
  const auto script = read_n1_script("# a flight\n 1.5 mode A\n\n2 take mobile # pilot\n2 loss 0.01\n3 restart\n");
  ASSERT_EQ(script.size(), 4U);
  EXPECT_EQ(script[0].at, core::TimePoint{milliseconds(1500)});
  EXPECT_EQ(script[1].value, 'm');
  EXPECT_NEAR(script[2].value, 0.01, 1e-12);
  for (const char* const bad : {"x mode A", "1 mode", "1 mode B", "1 fly", "1 loss 2", "1 loss nan", "1 restart 3",
                                "2 mode A\n1 mode F", "1 mode A F", "-1 mode A", "nan mode A"}) {
    EXPECT_THROW((void)read_n1_script(bad), N1ScriptError) << bad;
  }
  try {
    (void)read_n1_script("1 mode A\n\n2 wobble\n");
    FAIL();
  } catch (const N1ScriptError& wrong) {
    EXPECT_EQ(wrong.line(), 3);
  }
}

}  // namespace
}  // namespace m100::sim
