// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/state_messages.h"

#include <gtest/gtest.h>

#include <string>

namespace m100::companion {
namespace {

TEST(StateMessages, AreInNorthEastDown) {
  app::TickRecord<double> record;
  record.estimate.x = {.position_m = 1.0, .velocity_m_s = 0.1};
  record.estimate.y = {.position_m = 2.0, .velocity_m_s = 0.2};
  record.estimate.height_m = 3.0;
  record.estimate.climb_m_s = 0.3;
  const mavlink::LocalPositionNed position = position_of(record);
  EXPECT_EQ(position.x, 1.F);
  EXPECT_EQ(position.y, -2.F);
  EXPECT_EQ(position.z, -3.F);
  EXPECT_EQ(position.vx, 0.1F);
  EXPECT_EQ(position.vy, -0.2F);
  EXPECT_EQ(position.vz, -0.3F);
}

TEST(StateMessages, AttitudeIsFrdInNed) {
  app::TickRecord<double> record;
  record.estimate.yaw_rad = 0.5;
  mavlink::AttitudeQuaternion q = attitude_of(record);
  EXPECT_NEAR(q.q1, std::cos(0.25), 1e-6);
  EXPECT_NEAR(q.q4, -std::sin(0.25), 1e-6) << "counter-clockwise is negative about down";
  record.estimate.yaw_rad = 0.0;
  record.estimate.x.tilt_rad = 0.2;  // nose down in our frame
  q = attitude_of(record);
  EXPECT_NEAR(q.q3, -std::sin(0.1), 1e-6) << "nose down is negative pitch about right";
  record.estimate.x.tilt_rad = 0.0;
  record.estimate.y.tilt_rad = 0.2;
  q = attitude_of(record);
  EXPECT_NEAR(q.q2, std::sin(0.1), 1e-6) << "right side down is positive in both";
}

TEST(StateMessages, TheHeartbeatSaysWhoHasControlAndHowItGoes) {
  app::TickRecord<double> record;
  EXPECT_EQ(heartbeat_of(record).base_mode, 1);
  EXPECT_EQ(heartbeat_of(record).system_status, 3);
  record.authority.in_control = true;
  record.supervised.failsafe_state = safety::FailsafeState::kNominal;
  EXPECT_EQ(heartbeat_of(record).base_mode, 1 + 8 + 128);
  EXPECT_EQ(heartbeat_of(record).system_status, 4);
  record.supervised.failsafe_state = safety::FailsafeState::kCoast;
  EXPECT_EQ(heartbeat_of(record).system_status, 5);
  record.supervised.failsafe_state = safety::FailsafeState::kRelease;
  EXPECT_EQ(heartbeat_of(record).system_status, 6);
}

TEST(StateMessages, WhatIsNotKnownIsSaidSo) {
  app::TickRecord<double> record;
  EXPECT_EQ(battery_of(record).battery_remaining, -1);
  EXPECT_EQ(battery_of(record).voltages[9], 65535);
  EXPECT_EQ(estimator_of(record).flags, 0);
  record.telemetry.items = static_cast<std::uint16_t>(protocol::TelemetryItem::kBattery);
  record.telemetry.battery_percent = 77;
  EXPECT_EQ(battery_of(record).battery_remaining, 77);
}

std::string put_together(const std::string& sentence, int& pieces) {
  std::string all;
  mavlink::StatusText message;
  pieces = 0;
  for (std::uint8_t piece = 0; status_text(sentence, 6, 9, piece, message); ++piece, ++pieces) {
    EXPECT_EQ(message.chunk_seq, piece);
    EXPECT_EQ(message.id, sentence.size() > 50 ? 9 : 0);
    all += std::string(message.text.data(), strnlen(message.text.data(), message.text.size()));
  }
  return all;
}

TEST(StateMessages, ASentenceIsCutIntoPiecesThatGiveItAgain) {
  int pieces = 0;
  for (const std::size_t size : {1U, 49U, 50U, 51U, 99U, 101U, 250U}) {
    std::string sentence;
    for (std::size_t i = 0; i < size; ++i) {
      sentence += static_cast<char>('a' + i % 26);
    }
    EXPECT_EQ(put_together(sentence, pieces), sentence);
    EXPECT_EQ(pieces, static_cast<int>(size <= 50 ? 1 : size / 50 + 1)) << size;
  }
  EXPECT_EQ(put_together("", pieces), "");
  EXPECT_EQ(pieces, 0);
}

}  // namespace
}  // namespace m100::companion
