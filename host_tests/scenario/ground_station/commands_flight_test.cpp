// SPDX-License-Identifier: BSD-3-Clause
// Take-off and landing by signed orders of the room, and what a ground station requests when it connects.
#include <algorithm>
#include <array>

#include "host_tests/lab/frames/hex.h"
#include "host_tests/scenario/ground_station/ground_station_flight.h"

namespace m100::ground_station {
namespace {

using GroundStationOrdersFlight = GroundStationFlight;

/// Sends an unsigned broadcast command, from a sender without the key.
void send_unsigned(GroundStation& ground_station, std::uint16_t command) {
  ground_station.send_unauthorized(mavlink::encode(mavlink::CommandLong{.param1 = 1.F, .command = command},
                                                   GroundStation::kSender, ground_station.frames)
                                       .bytes());
}

/// A message of QGroundControl, and our answer.
struct Exchange {
  std::string_view name;
  std::string_view frame_hex;    ///< from system 255, component 190
  std::uint32_t answer_id = 0;   ///< of the message
  std::string_view payload_hex;  ///< of the answer; empty: there is none
};
/// How QGroundControl connects to a vehicle, and how it uploads and clears lists (4 items; type 0 mission, 1 fence, 2
/// rally points, 255 all). Frames and answers were made by node-mavlink 2.3.0.
constexpr std::array kConnection{
    Exchange{"HEARTBEAT", "fd09000000ffbe000000000000000608c00403e473", 0, ""},
    Exchange{"REQUEST_MESSAGE AUTOPILOT_VERSION",
             "fd20000001ffbe4c000000001443000000000000000000000000000000000000000000000000000201018d65", 77,
             "0002030000000000ffbe"},
    Exchange{"REQUEST_AUTOPILOT_CAPABILITIES",
             "fd20000002ffbe4c00000000803f00000000000000000000000000000000000000000000000008020101ba9a", 77,
             "0802030000000000ffbe"},
    Exchange{"PARAM_REQUEST_LIST", "fd01000003ffbe15000001adbd", 22,
             "0000803f010000004d41565f5359535f494400000000000009"},
    Exchange{"PARAM_REQUEST_READ 0", "fd04000004ffbe140000000001017971", 22,
             "0000803f010000004d41565f5359535f494400000000000009"},
    Exchange{"MISSION_REQUEST_LIST 0", "fd02000005ffbe2b00000101b0e2", 44, "0000ffbe"},
    Exchange{"MISSION_ACK 0", "fd02000006ffbe2f000001017fef", 0, ""},
    Exchange{"MISSION_REQUEST_LIST 1", "fd03000007ffbe2b0000010101d2d8", 44, "0000ffbe01"},
    Exchange{"MISSION_ACK 1", "fd04000008ffbe2f000001010001b22e", 0, ""},
    Exchange{"MISSION_REQUEST_LIST 2", "fd03000009ffbe2b00000101024173", 44, "0000ffbe02"},
    Exchange{"MISSION_ACK 2", "fd0400000affbe2f000001010002f8af", 0, ""},
    Exchange{"MISSION_COUNT 0", "fd0400000bffbe2c000004000101c23e", 47, "ffbe03"},
    Exchange{"MISSION_COUNT 1", "fd0500000cffbe2c0000040001010161d4", 47, "ffbe0301"},
    Exchange{"MISSION_COUNT 2", "fd0500000dffbe2c000004000101025c7b", 47, "ffbe0302"},
    Exchange{"MISSION_WRITE_PARTIAL_LIST", "fd0600000effbe2600000000020001011cd7", 47, "ffbe03"},
    Exchange{"MISSION_CLEAR_ALL 0", "fd0200000fffbe2d0000010110b7", 47, "ffbe03"},
    Exchange{"MISSION_CLEAR_ALL 1", "fd03000010ffbe2d0000010101d23f", 47, "ffbe0301"},
    Exchange{"MISSION_CLEAR_ALL 2", "fd03000011ffbe2d00000101029d39", 47, "ffbe0302"},
    Exchange{"MISSION_CLEAR_ALL 255", "fd03000012ffbe2d00000101ff8481", 47, "ffbe03ff"}};

mavlink::Frame frame_of(std::string_view hex) {
  const std::vector<std::byte> bytes = lab::from_hex(hex).value();
  mavlink::Frame frame{.size = bytes.size()};
  std::ranges::copy(bytes, frame.space.begin());
  return frame;
}

TEST_F(GroundStationOrdersFlight, TakesOffAndLandsByOrderAndNotByAnythingElse) {
  RecordProperty("promise", "R15");
  ASSERT_TRUE(start_flight({"--take-off", "--once"}, {"--on-ground"})) << error();
  ASSERT_TRUE(receive_until([&] { return attitudes > 0 && battery >= 0; }));
  for (int i = 0; i < 50; ++i) {
    send_unsigned(*ground_station, kTakeOff);
    (void)ground_station->run_until([] { return false; }, 0.05);
  }
  ASSERT_TRUE(send_command(kGuidedEnable, 1.F));
  EXPECT_EQ(answers[kGuidedEnable], 1) << "the order to engage must not cause a take-off";
  ASSERT_TRUE(send_command(kTakeOff, 0.F, 5.F));
  EXPECT_EQ(answers[kTakeOff], 2) << "the autopilot's take-off has a fixed height";
  ASSERT_TRUE(send_command(kLand, 0.F));
  EXPECT_EQ(answers[kLand], 1) << "the aircraft does not fly yet";
  EXPECT_EQ(noted("obtain_control"), 0U);
  EXPECT_NEAR(truth.z, 0.0, 0.02);

  ASSERT_TRUE(send_command(kTakeOff, 0.F));
  EXPECT_EQ(answers[kTakeOff], 0);
  ASSERT_TRUE(receive_until([&] { return said.find("the law takes over") != std::string::npos; })) << said;
  const Place start{truth.x, truth.y, -1.2};
  (void)ground_station->run_until([] { return false; }, 3.0);
  EXPECT_LT(distance(truth, start), kAtCorner_m) << "at " << truth.x << " " << truth.y << " " << truth.z;
  fly_to({start.x + 1.0, start.y, start.z});
  ASSERT_TRUE(send_command(kLand, 0.F));
  EXPECT_EQ(answers[kLand], 0);
  ASSERT_TRUE(ground_station->run_to_end(60.0).has_value()) << error();
  EXPECT_NEAR(truth.z, 0.0, 0.02);
  EXPECT_EQ(noted("\"received\",\"name\":\"task_takeoff\""), 1U);
  EXPECT_EQ(noted("\"received\",\"name\":\"task_land\""), 1U);
  const Json flown = reported();
  EXPECT_EQ(flown["landed"], true);
  EXPECT_EQ(flown["released"], true);
  EXPECT_EQ(run({"replay", log.string()}), 0) << "the log with orders does not replay: " << error();
}

// Catches a ground station that waits in vain for a parameter or a list while it connects, an upload that is not
// refused, and an answer to a sender without the key.
TEST_F(GroundStationOrdersFlight, QGroundControlConnectsAndItsListsAreRefused) {
  ground_station->network = {};
  ASSERT_TRUE(start_flight({"--once"})) << error();
  ASSERT_TRUE(receive_until([&] { return attitudes > 0; }));
  std::vector<std::pair<std::uint32_t, std::string>> heard;
  const auto is_answered = [&](const Exchange& one) {
    return std::ranges::count(heard, std::pair(one.answer_id, std::string(one.payload_hex))) == 1;
  };
  ground_station->on_frame = [&](const mavlink::FrameView& frame) {
    heard.emplace_back(frame.id, lab::to_hex(frame.payload));
  };
  for (const Exchange& one : kConnection) {
    ground_station->send_unauthorized(frame_of(one.frame_hex).bytes());
  }
  ASSERT_TRUE(receive_until([&] { return heard.size() > 20; })) << "the state of a second";
  EXPECT_TRUE(std::ranges::none_of(kConnection, is_answered));
  for (const Exchange& one : kConnection) {
    heard.clear();
    (void)ground_station->send(frame_of(one.frame_hex));
    EXPECT_TRUE(one.payload_hex.empty() || receive_until([&] { return is_answered(one); })) << one.name;
  }
  ground_station->signal(SIGINT);
  (void)ground_station->run_to_end(30.0);
  const Json counts = reported()["ground_station"];
  EXPECT_EQ(counts["orders"], 2);
  EXPECT_EQ(counts["requests"], 13);
  EXPECT_EQ(counts["requests_lost"], 0);
}

}  // namespace
}  // namespace m100::ground_station
