// SPDX-License-Identifier: BSD-3-Clause
// m100 with poses over UDP: poses that are not signed with the key, or are replayed, must have no effect.
#include <sys/stat.h>

#include <cmath>

#include "host_tests/scenario/ground_station/ground_station_flight.h"
#include "protocol/mavlink/messages.h"

namespace m100::ground_station {
namespace {

using mavlink::AttPosMocap;

constexpr double kStartAndFlight_s = 60.0;

struct SignedPose : GroundStationTest {
  SignedPose() { seed = 1; }
  Words words(const std::string& subcommand, const Words& more) const {
    const Words line{subcommand,      "--port", ground_station->port(), "--pose-port", ground_station->pose_port(),
                     "--mavlink-key", key};
    return with(subcommand == "fly" ? fly_words(*ground_station, key) : line, more);
  }
};

/// Sends poses far from the true one, without the key.
struct UnauthorizedSender {
  explicit UnauthorizedSender(GroundStation& of) : ground_station(of) {
    ground_station.on_pose = [this](const AttPosMocap& pose) { send(pose); };
  }
  void send(AttPosMocap false_pose) {
    false_pose.x += 2.F;
    ++false_pose.time_usec;
    mavlink::Frame frame = mavlink::encode(false_pose, GroundStation::kSender, ground_station.frames);
    switch (turn++ % 8) {
      case 0:
        ground_station.send_unauthorized(frame.bytes());
        break;
      case 2: {
        mavlink::Key other = GroundStation::kKey;
        other.back() ^= std::byte{1};
        mavlink::sign(frame, other, GroundStation::kLink, ground_station.stamp());
        ground_station.send_unauthorized(frame.bytes());
        break;
      }
      case 4:
        if (ground_station.recorded.size() > 100) {
          ground_station.send_unauthorized(ground_station.recorded[ground_station.recorded.size() - 100]);
          ++replayed;
        }
        break;
      case 6: {  // a valid packet, changed on the way
        if (!ground_station.recorded.empty()) {
          Packet changed = ground_station.recorded.back();
          changed[20] ^= std::byte{4};
          ground_station.send_unauthorized(changed);
        }
        break;
      }
      default:
        break;
    }
  }
  GroundStation& ground_station;
  std::uint64_t turn = 0;
  std::uint64_t replayed = 0;
};

// 5 % of the packets are lost, doubled and overtaken, and another sender permanently sends false poses.
TEST_F(SignedPose, FliesThroughABadNetworkAndBelievesNobodyElse) {
  ground_station->network.lost = ground_station->network.doubled = ground_station->network.swapped = 0.05;
  UnauthorizedSender sender(*ground_station);
  ground_station->start_autopilot(events);
  std::uint64_t questions = 0;
  ground_station->on_frame = [&](const mavlink::FrameView& frame) {
    questions += mavlink::is<mavlink::Timesync>(frame) ? 1U : 0U;
  };
  ASSERT_TRUE(
      ground_station->start(words("fly", {"--take-control", "--once", "--hold", "8", "--log", log.string()}), errors))
      << error();
  const std::optional<int> code = ground_station->run_to_end(kStartAndFlight_s);
  ASSERT_EQ(code, 0) << error();
  const Json flown = reported();
  EXPECT_EQ(flown["obtained"], true);
  EXPECT_NEAR(flown["position_m"][0].get<double>(), 0.0, 0.5)
      << "the aircraft must hover and not follow the false poses";
  const Json counts = flown["pose_link"]["signatures"];
  EXPECT_GT(counts["accepted"], 800);
  // Everything that arrived was read, except what arrived after the last tick.
  constexpr std::uint64_t kLastWords = 10;
  EXPECT_NEAR(counts["accepted"].get<double>(), static_cast<double>(ground_station->network.newer), kLastWords);
  EXPECT_NEAR(counts["replayed"].get<double>(),
              static_cast<double>(ground_station->network.not_newer + sender.replayed), kLastWords);
  EXPECT_NEAR(counts["unsigned"].get<double>(), static_cast<double>(sender.turn) / 8.0, kLastWords);
  EXPECT_NEAR(counts["wrong"].get<double>(), static_cast<double>(sender.turn) / 8.0, kLastWords);
  EXPECT_EQ(counts["full_ticks"], 0);
  EXPECT_EQ(flown["pose_link"]["refused_senders"], 0);
  EXPECT_GT(questions, 20U) << "too few time requests reached the true sender";
  EXPECT_EQ(ground_station->wrongly_signed, 0U);
  EXPECT_FALSE(ground_station->unauthorized().receive()) << "a time request went to another sender";
  EXPECT_EQ(run({"replay", log.string()}), 0) << "the log does not replay without the key: " << error();
  EXPECT_EQ(scenario::text_of(log).find(GroundStation::key_text()), std::string::npos);
}

// Catches a program that keeps the last time stamp only while it runs: a recording of one flight would be accepted as
// the pose of the next one.
TEST_F(SignedPose, WhatAnEarlierFlightAcceptedIsRefusedByTheNext) {
  ground_station->start_autopilot(events);
  ASSERT_TRUE(ground_station->start(words("fly", {"--dry-run", "--hold", "1"}), errors)) << error();
  ASSERT_EQ(ground_station->run_to_end(kStartAndFlight_s), 0) << error();
  ASSERT_GT(ground_station->recorded.size(), 60U);
  // Packets after the last tick, many on a busy machine, were never accepted: they would not count as replayed.
  const std::vector<Packet> recorded(ground_station->recorded.begin(), ground_station->recorded.begin() + 30);
  // The sender is off, and an attacker replays its flight.
  ground_station->sends_poses = false;
  std::size_t next = 0;
  ground_station->on_pose = [&](const AttPosMocap&) {
    if (next < recorded.size()) {
      ground_station->send_unauthorized(recorded[next++]);
    }
  };
  ASSERT_TRUE(ground_station->start(words("fly", {"--dry-run", "--hold", "1"}), errors)) << error();
  EXPECT_EQ(ground_station->run_to_end(kStartAndFlight_s), 2);
  EXPECT_NE(error().find("no pose within 5 s"), std::string::npos) << error();
  EXPECT_NE(error().find("0 frames signed with the key"), std::string::npos) << error();
  EXPECT_EQ(error().find(" 0 sent before"), std::string::npos) << error();
  // The true sender is accepted at once, because its stamps continue.
  ground_station->sends_poses = true;
  ground_station->on_pose = {};
  ASSERT_TRUE(ground_station->start(words("fly", {"--dry-run", "--hold", "1"}), errors)) << error();
  EXPECT_EQ(ground_station->run_to_end(kStartAndFlight_s), 0) << error();
}

TEST_F(SignedPose, IsRecorded) {
  ground_station->start_autopilot(events);
  ASSERT_TRUE(
      ground_station->start(words("record", {"--hold", "2", "--log", log.string(), "--json", result.string()}), errors))
      << error();
  ASSERT_EQ(ground_station->run_to_end(kStartAndFlight_s), 0) << error();
  EXPECT_GT(reported()["streams"]["pose"]["samples"], 150);
  EXPECT_GT(reported()["signatures"]["accepted"], 150);
  EXPECT_EQ(reported()["signatures"]["unsigned"], 0);
}

TEST_F(SignedPose, NothingComesOverANetworkWithoutAKey) {
  const Words bare{"--port", ground_station->port(), "--pose-port", ground_station->pose_port(), "--log", log.string()};
  for (const char* const subcommand : {"fly", "record"}) {
    EXPECT_EQ(run(with({subcommand}, bare)), 2);
    EXPECT_EQ(error(),
              "m100: --pose-port: " + ground_station->pose_port() +
                  ": poses over a network must be signed; name the key with --mavlink-key, or take unsigned poses "
                  "of this board alone, with udp:127.0.0.1:PORT and --pose-from\n");
  }
  const auto refused = [&](const std::string& pose_port, const std::string& with_key, const std::string& because) {
    const Words line{"fly",    "--port",   ground_station->port(), "--pose-port", pose_port, "--mavlink-key",
                     with_key, "--dry-run"};
    EXPECT_EQ(run(with(line, models())), 2);
    EXPECT_NE(error().find(because), std::string::npos) << error();
    const std::string said = error();
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
  };
  refused("udp:0", key, "a UDP port is written udp:PORT");
  refused("udp:14550x", key, "a UDP port is written udp:PORT");
  EXPECT_EQ(run({"fly", "--dry-run", "--port", ground_station->port(), "--mavlink-key", key}), 2);
  EXPECT_NE(error().find("--mavlink-key: is the key of the pose port"), std::string::npos) << error();
  // The autopilot's port is opened before the key is read.
  ground_station->start_autopilot(events);
  key += "s";
  (void)ground_station->start(words("fly", {"--dry-run"}), errors);
  EXPECT_EQ(ground_station->run_to_end(kStartAndFlight_s), 2);
  EXPECT_NE(error().find("cannot be read"), std::string::npos) << error();
  key.pop_back();
  ASSERT_EQ(::chmod(key.c_str(), 0640), 0);
  (void)ground_station->start(words("fly", {"--dry-run"}), errors);
  EXPECT_EQ(ground_station->run_to_end(kStartAndFlight_s), 2);
  EXPECT_NE(error().find("holds a key that others can read: chmod 600"), std::string::npos) << error();
}

}  // namespace
}  // namespace m100::ground_station
