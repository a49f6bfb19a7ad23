// SPDX-License-Identifier: BSD-3-Clause
// The emulated autopilot, command by command, as the raw frames of a client see it (protocol, sections 4 to 6 and 11).
#include "firmware/core/frames.h"
#include "host_tests/unit/sim/n1_fixture.h"
#include "protocol/aes256.h"

namespace m100::sim {
namespace {

TEST_F(N1Test, TelemetryStreamsBeforeActivationAtTheAssistantsRates) {
  run(seconds(2));
  EXPECT_EQ(pushes(ids::kTelemetry), 100U);
}

// The autopilot counts its own milliseconds, and times all its actions by them.
TEST_F(N1Test, RunsOnItsOwnClock) {
  start({.clock_drift_ppm = 2000.0});
  autopilot->advance(core::TimePoint(seconds(100)));
  EXPECT_EQ(autopilot->record().telemetry_packages, 5010U);          // half of its slots have an item
  EXPECT_NEAR(core::seconds<double>(vehicle.age()), 100.0, 0.0025);  // the aircraft moves in our time
  EXPECT_LE(autopilot->ticked_at(), core::TimePoint(seconds(100)));
  EXPECT_GT(autopilot->ticks_next(), core::TimePoint(seconds(100)));
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
  // The identical frame once more: executing it a second time would obtain control.
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

TEST_F(N1Test, GivingBackWhatWasOnlyAskedForBeginsAnew) {
  activate();
  ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 3U);
  EXPECT_EQ(code(ids::kControlRequest, bytes({0})), 1U);
  EXPECT_EQ(code(ids::kControlRequest, bytes({1})), 3U);
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
  autopilot->happen(N1EventKind::kIoc, 1);
  EXPECT_EQ(code(ids::kControlRequest, bytes({1})), 0xC9U);
  autopilot->happen(N1EventKind::kIoc, 0);
  autopilot->happen(N1EventKind::kTake, 'm');
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(code(ids::kControlRequest, bytes({1})), 3U);
  }
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
  cipher_of_client = &wrong;
  heard.clear();
  const auto refused = ask(ids::kControlRequest, bytes({1}), 3, &wrong);
  ASSERT_TRUE(refused && refused->size() == 2U);
  EXPECT_EQ(*refused, bytes({0x00, 0xFF})) << "in plain: a client with another key could not read it";
}

// A command that was decrypted but is refused gets the same answer as a plain one, because its key was right.
TEST_F(N1Test, ARefusedEncryptedCommandIsAnsweredAsThePlainOne) {
  const protocol::Aes256 key(protocol::CipherKey{1, 2, 3});
  start({.cipher = &key});
  activate();
  cipher_of_client = &key;
  const std::vector<std::byte> sixth = bytes({6, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  const auto plain = ask(ids::kTelemetryFrequency, sixth, 4);
  const auto encrypted = ask(ids::kTelemetryFrequency, sixth, 5, &key);
  ASSERT_TRUE(plain && encrypted);
  EXPECT_EQ(*encrypted, *plain);
  EXPECT_EQ(*encrypted, bytes({1, 0}));
  EXPECT_FALSE(ask(ids::kControlRequest, bytes({1, 1}), 6).has_value()) << "of a wrong size: no answer";
  EXPECT_FALSE(ask(ids::kControlRequest, bytes({1, 1}), 7, &key).has_value());
  EXPECT_EQ(autopilot->record().bad_commands, 4U);
}

TEST_F(N1Test, AcknowledgementsOfOneCommandCanBeLostByName) {
  activate();
  autopilot->happen(N1EventKind::kLoseAcks, 1, N1Request::kReleaseControl);
  ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 3U);
  ASSERT_EQ(code(ids::kControlRequest, bytes({1})), 2U);
  EXPECT_FALSE(ask(ids::kControlRequest, bytes({0})).has_value());
  EXPECT_EQ(code(ids::kControlRequest, bytes({0})), 1U) << "the lost answer was 4";
  autopilot->happen(N1EventKind::kLoseAcks, 2);
  EXPECT_FALSE(ask(ids::kVersionQuery, bytes({0})).has_value());
  EXPECT_FALSE(ask(ids::kControlRequest, bytes({0})).has_value());
  EXPECT_EQ(code(ids::kControlRequest, bytes({0})), 1U);
}

TEST_F(N1Test, ARestartForgetsEverything) {
  obtain();
  autopilot->happen(N1EventKind::kRestart);
  run(milliseconds(10));  // empties the line
  heard.clear();
  run(seconds(1));
  EXPECT_TRUE(heard.empty()) << "booting";
  run(seconds(2));
  EXPECT_GT(pushes(ids::kTelemetry), 0U);
  EXPECT_EQ(code(ids::kControlRequest, bytes({1})), 0xFF01U);
}

TEST(N1Script, NamesALieAndItsSize) {
  const auto script = read_n1_script("1 lie standing\n2 lie drift\n3 lie drift -0.1\n");
  ASSERT_EQ(script.size(), 3U);
  EXPECT_EQ(script[0].fault, find_sensor_fault("standing"));
  EXPECT_EQ(script[1].value, find_sensor_fault("drift")->size);
  EXPECT_NEAR(script[2].value, -0.1, 1e-12);
  for (const char* const bad : {"1 lie", "1 lie gravely", "1 lie standing 2", "1 lie drift fast", "1 lie drift 1 2",
                                "1 lie drift nan", "1 lie drift 1e9"}) {
    EXPECT_THROW((void)read_n1_script(bad), N1ScriptError) << bad;
  }
}

// Catches a sensor fault that changes another channel than its own, or no channel.
TEST(SensorFaults, EachChangesItsOwnChannelAlone) {
  for (const SensorFault& fault : sensor_faults()) {
    ASSERT_NE(fault.pose == nullptr, fault.telemetry == nullptr) << fault.name;
    SensorFaultInjector fault_injector(fault);
    bool changed = false;
    for (int i = 0; i < 20; ++i) {
      PoseSample pose;
      pose.captured = core::TimePoint{milliseconds(100 * i)};
      pose.position_w_m = {0.1 * i + 1.0, 0.02 * i * i + 2.0, 0.05 * i + 1.0};
      protocol::Telemetry telemetry;
      telemetry.time.ticks = static_cast<std::uint32_t>(40 * i);
      const core::Quaternion<double> q =
          core::flip_yz(core::quaternion_of(core::Euler<double>{0.05 + 0.01 * i, 0.1 - 0.01 * i, 0.2}));
      telemetry.attitude = {static_cast<float>(q.w), static_cast<float>(q.x), static_cast<float>(q.y),
                            static_cast<float>(q.z)};
      telemetry.angular_velocity_frd_rad_s = {0.1F + 0.01F * static_cast<float>(i), 0.2F, 0.3F};
      telemetry.acceleration = {0.1F, 0.2F + 0.01F * static_cast<float>(i), -1.F};
      telemetry.velocity_ned_m_s = {0.F, 0.F, 0.5F};
      telemetry.battery_percent = 90;
      PoseSample reported_pose = pose;
      protocol::Telemetry reported = telemetry;
      fault_injector.apply(reported_pose);
      fault_injector.apply(reported);
      const bool pose_changed = reported_pose.position_w_m != pose.position_w_m ||
                                reported_pose.yaw_rad != pose.yaw_rad || reported_pose.stamp != pose.stamp;
      const bool telemetry_changed =
          reported.attitude != telemetry.attitude || reported.acceleration != telemetry.acceleration ||
          reported.velocity_ned_m_s != telemetry.velocity_ned_m_s ||
          reported.angular_velocity_frd_rad_s != telemetry.angular_velocity_frd_rad_s ||
          reported.position.height_m != telemetry.position.height_m || reported.time.ticks != telemetry.time.ticks ||
          reported.battery_percent != telemetry.battery_percent;
      EXPECT_FALSE(fault.pose == nullptr ? pose_changed : telemetry_changed) << fault.name;
      changed = changed || pose_changed || telemetry_changed;
    }
    EXPECT_TRUE(changed) << fault.name;
  }
}

TEST(N1Script, IsReadLineByLineAndErrorsNameTheLine) {
  const auto script = read_n1_script("# a flight\n 1.5 mode A\n\n2 take mobile # pilot\n2 loss 0.01\n3 restart\n");
  ASSERT_EQ(script.size(), 4U);
  EXPECT_EQ(script[0].at, core::TimePoint{milliseconds(1500)});
  EXPECT_EQ(script[1].value, 'm');
  EXPECT_NEAR(script[2].value, 0.01, 1e-12);
  EXPECT_EQ(read_n1_script("1 lose_acks 2").front().request, N1Request::kAny);
  EXPECT_EQ(read_n1_script("1 lose_acks 2 obtain_control # twice").front().request, N1Request::kObtainControl);
  for (const char* const bad :
       {"x mode A", "1 mode", "1 mode B", "1 fly", "1 loss 2", "1 loss nan", "1 restart 3", "2 mode A\n1 mode F",
        "1 mode A F", "-1 mode A", "nan mode A", "1 lose_acks", "1 lose_acks 2 movement", "1 lose_acks 2 task 3"}) {
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
