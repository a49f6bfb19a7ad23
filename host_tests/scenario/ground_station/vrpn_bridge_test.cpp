// SPDX-License-Identifier: BSD-3-Clause
// The bridge as a client of a VRPN server, for which a stand-in answers that follows only the protocol.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <csignal>
#include <string>

#include "host_tests/scenario/ground_station/ground_station.h"
#include "host_tests/scenario/program/program_fixture.h"
#include "host_tests/unit/lab/vrpn_stand_in.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/pose_messages.h"
#include "protocol/mavlink/signature.h"

namespace m100::ground_station {
namespace {

struct VrpnBridge : scenario::ProgramTest {};

/// Waits for a text request on `asks`, then connects back over TCP. @returns the connection; -1 if no request came.
int connection_to_who_asks(const Socket& asks) {
  for (int i = 0; i < 6000; ++i) {
    if (const std::optional<Packet> packet = asks.receive()) {
      const std::string text(reinterpret_cast<const char*>(packet->data()), packet->size());
      const std::size_t space = text.find(' ');
      EXPECT_EQ(text.back(), '\0') << "the request must end with a zero byte";
      sockaddr_in client{};
      client.sin_family = AF_INET;
      client.sin_port = htons(static_cast<std::uint16_t>(std::stoi(text.substr(space + 1))));
      EXPECT_EQ(inet_pton(AF_INET, text.substr(0, space).c_str(), &client.sin_addr), 1) << text;
      const int connection = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      EXPECT_EQ(::connect(connection, reinterpret_cast<const sockaddr*>(&client), sizeof(client)), 0);
      return connection;
    }
    usleep(10000);
  }
  return -1;
}

TEST_F(VrpnBridge, PosesOfATrackerArePassedOnSigned) {
  signal(SIGPIPE, SIG_IGN);
  const Socket asks, m100;
  const std::filesystem::path counts = folder / "bridge.json";
  scenario::Process bridge(M100_LAB_PROGRAM,
                           {"bridge", "--vrpn", "m100@127.0.0.1:" + std::to_string(asks.port()), "--to",
                            "127.0.0.1:" + std::to_string(m100.port()), "--mavlink-key",
                            key_file(GroundStation::key_text()).string(), "--axes", "enu", "--json", counts.string()});
  const int connection = connection_to_who_asks(asks);
  ASSERT_GE(connection, 0);
  std::array<char, 24> cookie{};
  ASSERT_EQ(::recv(connection, cookie.data(), cookie.size(), MSG_WAITALL), 24);
  EXPECT_EQ(std::string(cookie.data(), 10), "vrpn: ver.");
  lab::bridge::VrpnStandIn server;
  server.cookie();
  server.name(-1, 0, "m100");
  server.name(-2, 5, "vrpn_Tracker Pos_Quat");
  for (int i = 0; i < 50; ++i) {
    server.pose(0, 5, 0, 100.0 + 0.01 * i, {1.0, 2.0, 3.0}, {0.0, 0.0, 0.0, 1.0});
  }
  ASSERT_EQ(::send(connection, server.bytes.data(), server.bytes.size(), 0), static_cast<ssize_t>(server.bytes.size()));
  int poses = 0;
  std::uint64_t last_us = 0;
  for (int i = 0; i < 6000 && poses < 50; ++i) {
    while (const std::optional<Packet> packet = m100.receive()) {
      mavlink::Parser parser;
      parser.consume(*packet, [&](const mavlink::FrameView& frame) {
        EXPECT_TRUE(is_signed_with(frame, GroundStation::kKey));
        const auto seen = mavlink::decode<mavlink::AttPosMocap>(frame);
        EXPECT_EQ(seen.x, 2.F) << "north must be the room's y";
        EXPECT_EQ(seen.y, 1.F);
        EXPECT_EQ(seen.z, -3.F);
        EXPECT_GT(seen.time_usec, last_us);
        last_us = seen.time_usec;
        ++poses;
      });
    }
    usleep(10000);
  }
  EXPECT_EQ(poses, 50);
  EXPECT_EQ(last_us, 100490000U);
  ::close(connection);
  EXPECT_EQ(bridge.wait(), 0) << "the bridge must end after the server";
  EXPECT_EQ(Json::parse(scenario::text_of(counts))["sent"], 50);
}

}  // namespace
}  // namespace m100::ground_station
