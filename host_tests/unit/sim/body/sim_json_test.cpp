// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/sim_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "host_tests/refusal.h"

namespace m100::sim {
namespace {

constexpr const char* kAnswer =
    "\n{\"timestamp\": 2.5, \"imu\": {\"gyro\": [0.1, 0.2, 0.3], \"accel_body\": [1, 2, -9.5]}, \"position\": [3, 4, "
    "-5], "
    "\"velocity\": [0.5, -0.25, 2], \"attitude\": [0.1, 0.2, 0.3]}\n";

std::string with(const std::string& old, const std::string& now) {
  std::string text = kAnswer;
  return text.replace(text.find(old), old.size(), now);
}

std::string refusal(const std::string& datagram) {
  return host_tests::refusal_by<PhysicsError>([&] { decode_answer(datagram); });
}

// The interface's description: u16 magic 18458, u16 rate, u32 count, 16 x u16, little endian.
TEST(SimJson, EncodesTheServoPacketByteForByte) {
  ServoPacket packet{.rate_hz = 400, .frame = 0x01020304, .pulse_us = {}};
  packet.pulse_us.fill(1000);
  packet.pulse_us[0] = 1501;
  const auto bytes = encode(packet);
  ASSERT_EQ(bytes.size(), 40U);
  const std::array<unsigned, 12> head{0x1A, 0x48, 0x90, 0x01, 0x04, 0x03, 0x02, 0x01, 0xDD, 0x05, 0xE8, 0x03};
  for (std::size_t i = 0; i < head.size(); ++i) {
    EXPECT_EQ(std::to_integer<unsigned>(bytes[i]), head[i]) << "byte " << i;
  }
}

// Catches a decoder that forgets to turn one of the vectors, or turns it about another axis.
TEST(SimJson, TurnsNedAndFrdIntoOurFrames) {
  const PhysicsAnswer answer = decode_answer(kAnswer);
  EXPECT_EQ(answer.time_s, 2.5);
  EXPECT_EQ(answer.position_w_m, (core::Vector<double, 3>(3.0, -4.0, 5.0)));
  EXPECT_EQ(answer.velocity_w_m_s, (core::Vector<double, 3>(0.5, 0.25, -2.0)));
  EXPECT_EQ(answer.rate_b_rad_s, (core::Vector<double, 3>(0.1, -0.2, -0.3)));
  EXPECT_EQ(answer.specific_force_b_m_s2, (core::Vector<double, 3>(1.0, -2.0, 9.5)));
  const core::Euler<double> attitude = core::euler_of(answer.rotation_wb);
  EXPECT_NEAR(attitude.roll_rad, 0.1, 1e-12);  // right side down in both
  EXPECT_NEAR(attitude.pitch_rad, -0.2, 1e-12);
  EXPECT_NEAR(attitude.yaw_rad, -0.3, 1e-12);
}

TEST(SimJson, AQuaternionWinsOverAngles) {
  const PhysicsAnswer answer = decode_answer(with("\"attitude\"", "\"quaternion\": [0.6, 0.8, 0, 0], \"attitude\""));
  EXPECT_NEAR(core::euler_of(answer.rotation_wb).roll_rad, 2.0 * std::atan2(0.8, 0.6), 1e-12);
}

TEST(SimJson, TakesTheLastLineAndFieldsItDoesNotKnow) {
  EXPECT_EQ(decode_answer("{\"timestamp\": 1}\n" + std::string(kAnswer)).time_s, 2.5);
  EXPECT_EQ(decode_answer(with("\"timestamp\"",
                               "\"rng_1\": 3, \"battery\": {\"voltage\": 22.2, \"current\": 9}, "
                               "\"velocity_wind\": [1, 2, 3], \"timestamp\""))
                .time_s,
            2.5);
}

struct Bad {
  const char* name;
  std::string datagram;
  std::string says;
};
class SimJsonRefuses : public ::testing::TestWithParam<Bad> {};
TEST_P(SimJsonRefuses, AndNamesWhatIsWrong) {
  EXPECT_NE(refusal(GetParam().datagram).find(GetParam().says), std::string::npos) << refusal(GetParam().datagram);
}
INSTANTIATE_TEST_SUITE_P(
    Answers, SimJsonRefuses,
    ::testing::Values(
        Bad{"Nothing", "", "not a JSON object"}, Bad{"CutShort", std::string(kAnswer).substr(0, 80), "not a JSON"},
        Bad{"AList", "[1, 2]", "not a JSON object"}, Bad{"NotANumber", with("-9.5", "NaN"), "not finite"},
        Bad{"Infinity", with("-9.5", "-Infinity"), "not finite"},
        Bad{"TooLarge", with("-9.5", "1e999"), "not a JSON object"},
        Bad{"Null", with("-9.5", "null"), "'imu.accel_body' is not a finite number"},
        Bad{"AWord", with("2.5", "\"now\""), "'timestamp' is not a finite number"},
        Bad{"NoTime", with("timestamp", "time"), "no 'timestamp'"},
        Bad{"NoAttitude", with("attitude", "angles"), "neither 'attitude' nor 'quaternion'"},
        Bad{"TwoNumbers", with("[3, 4, -5]", "[3, 4]"), "'position' is not a list of 3"},
        Bad{"LongQuaternion", with("\"attitude\": [0.1, 0.2, 0.3]", "\"quaternion\": [1, 1, 0, 0]"), "length 1"},
        Bad{"NoImu", with("\"imu\": {\"gyro\": [0.1, 0.2, 0.3], \"accel_body\": [1, 2, -9.5]}", "\"imu\": 1"),
            "'imu' is not an object"},
        Bad{"BadWind", with("\"timestamp\"", "\"velocity_wind\": [1], \"timestamp\""), "velocity_wind"}),
    [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace m100::sim
