// SPDX-License-Identifier: BSD-3-Clause
// The stream of a VRPN server, cut and damaged anywhere.
#include "host_tests/lab/bridge/vrpn.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "host_tests/lab/bridge/vrpn_source.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/unit/lab/refusal.h"
#include "host_tests/unit/lab/vrpn_stand_in.h"

namespace m100::lab::bridge {
namespace {

struct Read {
  std::vector<PlainPose> poses;
  bool goes_on = true;
};
Read read(VrpnStream& stream, const std::vector<std::byte>& bytes, std::size_t portion) {
  Read out;
  for (std::size_t at = 0; at < bytes.size() && out.goes_on; at += portion) {
    out.goes_on = stream.consume(std::span(bytes).subspan(at, std::min(portion, bytes.size() - at)),
                                 [&](const PlainPose& pose) { out.poses.push_back(pose); });
  }
  return out;
}

std::vector<std::byte> some_poses() {
  VrpnStandIn server;
  server.cookie();
  server.name(-1, 3, "m100");
  server.name(-1, 4, "other");
  server.name(-2, 7, "vrpn_Tracker Pos_Quat");
  server.name(-2, 8, "vrpn_Tracker Velocity");
  server.pose(3, 7, 0, 1.25, {1.0, 2.0, 3.0}, {0.0, 0.0, 0.0, 1.0});
  server.pose(4, 7, 0, 1.25, {9.0, 9.0, 9.0}, {0.0, 0.0, 0.0, 1.0});  // of another tracker
  server.pose(3, 7, 1, 1.25, {9.0, 9.0, 9.0}, {0.0, 0.0, 0.0, 1.0});  // of another sensor
  server.pose(3, 8, 0, 1.25, {9.0, 9.0, 9.0}, {0.0, 0.0, 0.0, 1.0});  // no pose
  server.pose(3, 7, 0, 1.26, {9.0, 9.0, 9.0}, {0.0, 0.0, 0.0, 0.0});  // no quaternion
  server.pose(3, 7, 0, 1.27, {4.0, 5.0, 6.0}, {0.6, 0.0, 0.0, 0.8});
  return server.bytes;
}

TEST(Vrpn, ThePosesOfOneTrackerAndSensorAreRead) {
  for (const std::size_t portion : {std::size_t{1}, std::size_t{7}, std::size_t{24}, std::size_t{10000}}) {
    VrpnStream stream("m100", 0);
    const Read out = read(stream, some_poses(), portion);
    EXPECT_TRUE(out.goes_on);
    ASSERT_EQ(out.poses.size(), 2U) << "in portions of " << portion;
    EXPECT_NEAR(out.poses[0].t_s, 1.25, 1e-9);
    EXPECT_EQ(out.poses[0].position_m.y(), 2.0);
    EXPECT_EQ(out.poses[1].body_to_world.w, 0.8) << "VRPN has w last";
    EXPECT_EQ(out.poses[1].body_to_world.x, 0.6);
    EXPECT_EQ(stream.senders(), (std::vector<std::string>{"m100", "other"}));
    EXPECT_EQ(stream.passed_over(), 3U);
  }
}

// A wrong name or sensor is the most common mistake with VRPN, so the message names the trackers that exist.
TEST(Vrpn, UnknownTrackerListsTheNames) {
  VrpnStream wrong("m200", 0), sensor("m100", 5), silent("m100", 0);
  EXPECT_TRUE(read(wrong, some_poses(), 100).poses.empty());
  EXPECT_TRUE(read(sensor, some_poses(), 100).poses.empty());
  EXPECT_EQ(wrong.silence_reason(), "the server has no tracker 'm200'; it named 'm100', 'other'");
  EXPECT_NE(sensor.silence_reason().find("no plausible pose of its sensor 5"), std::string::npos)
      << sensor.silence_reason();
  EXPECT_EQ(silent.silence_reason(), "the server has no tracker 'm100'; it named none");
}

/// The message with which the subcommand refuses. The key's file does not exist, so the subcommand never waits.
std::string refused(std::vector<std::string> words) {
  words.insert(words.begin(), {"bridge", "--mavlink-key", "/nowhere/key"});
  return refusal_of(add_bridge, words);
}

// Catches a duration for which the bridge would run for ever, and options that have no effect.
TEST(Bridge, OptionsThatMeanNothingAreRefused) {
  for (const char* const duration : {"nan", "inf", "-1", "1e7"}) {
    EXPECT_NE(refused({"--duration", duration}).find("--duration"), std::string::npos) << duration;
  }
  EXPECT_NE(refused({"--vrpn", "m100@10.0.0.2", "--from", "10.0.0.2"}).find("excludes"), std::string::npos);
  EXPECT_NE(refused({"--vrpn", "m100@10.0.0.2", "--listen", "udp:9763"}).find("excludes"), std::string::npos);
  EXPECT_NE(refused({"--sensor", "1"}).find("requires"), std::string::npos) << refused({"--sensor", "1"});
  EXPECT_NE(refused({"--duration", "60"}).find("/nowhere/key"), std::string::npos);
}

TEST(Vrpn, WhatIsNoVrpnEndsIt) {
  std::vector<std::byte> wrong = some_poses();
  wrong.front() = std::byte{'V'};
  VrpnStream stream("m100", 0);
  EXPECT_FALSE(read(stream, wrong, 5).goes_on);
  for (const int length : {0, 23, -1, 1 << 30}) {
    VrpnStandIn server;
    server.cookie();
    server.put32(length);
    server.bytes.resize(server.bytes.size() + 20);
    VrpnStream cut("m100", 0);
    EXPECT_FALSE(read(cut, server.bytes, 3).goes_on) << length;
  }
}

// Names are kept as long as the stream lives. Catches a server that sends 1000 names of 64 KiB.
TEST(Vrpn, ALongNameIsPassedOver) {
  VrpnStandIn server;
  server.cookie();
  server.name(-1, 1, std::string(VrpnStream::kMaxNameBytes - 1, 'a'));
  server.name(-1, 2, std::string(VrpnStream::kMaxNameBytes, 'b'));
  server.name(-1, 3, std::string(60000, 'c'));
  VrpnStream stream("m100", 0);
  EXPECT_TRUE(read(stream, server.bytes, 1000).goes_on);
  EXPECT_EQ(stream.senders(), (std::vector<std::string>{std::string(VrpnStream::kMaxNameBytes - 1, 'a')}));
}

// No damaged stream may give an impossible pose or use more memory than stated (run with the sanitizers). The
// conditions for a pose are stated independently of the reader's.
TEST(Vrpn, DamageGivesNoImpossiblePose) {
  std::mt19937 random(1);
  const std::vector<std::byte> good = some_poses();
  for (int round = 0; round < 20000; ++round) {
    std::vector<std::byte> bad = good;
    for (int i = 0; i < 4; ++i) {
      bad[24 + random() % (bad.size() - 24)] = static_cast<std::byte>(random());
    }
    VrpnStream stream("m100", 0);
    for (const PlainPose& pose : read(stream, bad, 1 + random() % 300).poses) {
      const core::Quaternion<double>& q = pose.body_to_world;
      ASSERT_LE(std::hypot(pose.position_m.x(), pose.position_m.y(), pose.position_m.z()), 1000.0 * std::sqrt(3.0))
          << "round " << round;
      ASSERT_NEAR(std::hypot(std::hypot(q.w, q.x), std::hypot(q.y, q.z)), 1.0, 0.011) << "round " << round;
      ASSERT_GE(pose.t_s, 0.0) << "round " << round;
    }
  }
}

TEST(Vrpn, AServerHasATrackerAndAnAddress) {
  const VrpnName name = vrpn_name("m100@10.0.0.2");
  EXPECT_EQ(name.tracker, "m100");
  EXPECT_EQ(name.host, "10.0.0.2");
  EXPECT_EQ(name.port, 3883);
  EXPECT_EQ(vrpn_name("a b@10.0.0.2:77").port, 77);
  for (const char* const wrong : {"", "m100", "@10.0.0.2", "m100@", "m100@host", "m100@10.0.0.2:", "m100@10.0.0.2:0"}) {
    EXPECT_THROW((void)vrpn_name(wrong), InputError) << wrong;
  }
}

}  // namespace
}  // namespace m100::lab::bridge
