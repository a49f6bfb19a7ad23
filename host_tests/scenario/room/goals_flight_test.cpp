// SPDX-License-Identifier: BSD-3-Clause
// The room flies m100: it engages by an order, flies a square by goals, reads the state back, and nobody else moves it.
#include <cmath>
#include <csignal>
#include <map>
#include <optional>

#include "host_tests/scenario/program/program_fixture.h"
#include "host_tests/scenario/room/room.h"
#include "protocol/mavlink/messages.h"

namespace m100::room {
namespace {

using scenario::json;

constexpr std::uint8_t kArmed = 128;
constexpr std::uint16_t kGuidedEnable = 92;
constexpr std::uint16_t kLand = 21;
constexpr std::uint16_t kMissionStart = 300;
constexpr std::uint16_t kOnlyPosition = 0b110111111000;
/// Of a corner, when the aircraft has come to rest there.
constexpr double kAtCorner_m = 0.25;

struct Place {
  double x = 0.0, y = 0.0, z = 0.0;  ///< NED
};
double distance(const Place& a, const Place& b) { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

mavlink::Frame goal_frame(const Place& place, std::uint8_t number) {
  return mavlink::encode(mavlink::SetPositionTargetLocalNed{.x = static_cast<float>(place.x),
                                                            .y = static_cast<float>(place.y),
                                                            .z = static_cast<float>(place.z),
                                                            .type_mask = kOnlyPosition,
                                                            .target_system = 1,
                                                            .coordinate_frame = 1},
                         Room::kSender, number);
}

struct GoalsFlight : scenario::ProgramTest {
  std::unique_ptr<Room> room;
  Place truth;
  mavlink::LocalPositionNed position;
  std::uint8_t base_mode = 0;
  std::uint64_t attitudes = 0, estimates = 0;
  int battery = -1;
  std::map<std::uint16_t, int> answers;  ///< by command
  std::vector<mavlink::MissionItemInt> mission;
  std::optional<int> carried_over;  ///< the result of the mission's transfer
  std::vector<int> reached;
  int mission_state = 0;
  std::map<std::string, float> parameters;
  std::string said;

  void SetUp() override {
    ProgramTest::SetUp();
    room = std::make_unique<Room>(folder, 2);
    room->network.lost = room->network.doubled = room->network.swapped = 0.05;
    room->on_pose = [this](const mavlink::AttPosMocap& seen) {
      truth = {static_cast<double>(seen.x), static_cast<double>(seen.y), static_cast<double>(seen.z)};
    };
    room->on_frame = [this](const mavlink::FrameView& frame) { hear(frame); };
  }
  void TearDown() override {
    room.reset();
    ProgramTest::TearDown();
  }

  void hear(const mavlink::FrameView& frame) {
    if (mavlink::is<mavlink::Heartbeat>(frame)) {
      base_mode = mavlink::decode<mavlink::Heartbeat>(frame).base_mode;
    } else if (mavlink::is<mavlink::LocalPositionNed>(frame)) {
      position = mavlink::decode<mavlink::LocalPositionNed>(frame);
    } else if (mavlink::is<mavlink::AttitudeQuaternion>(frame)) {
      ++attitudes;
    } else if (mavlink::is<mavlink::EstimatorStatus>(frame)) {
      ++estimates;
    } else if (mavlink::is<mavlink::BatteryStatus>(frame)) {
      battery = mavlink::decode<mavlink::BatteryStatus>(frame).battery_remaining;
    } else if (mavlink::is<mavlink::CommandAck>(frame)) {
      const auto answer = mavlink::decode<mavlink::CommandAck>(frame);
      answers[answer.command] = answer.result;
    } else if (mavlink::is<mavlink::StatusText>(frame)) {
      const auto text = mavlink::decode<mavlink::StatusText>(frame);
      said += std::string(text.text.data(), strnlen(text.text.data(), text.text.size()));
    } else {
      hear_mission(frame);
    }
  }
  void hear_mission(const mavlink::FrameView& frame) {
    if (mavlink::is<mavlink::MissionRequestInt>(frame)) {
      const auto asked = mavlink::decode<mavlink::MissionRequestInt>(frame);
      EXPECT_EQ(asked.target_system, Room::kSender.system);
      (void)room->send(mavlink::encode(mission.at(asked.seq), Room::kSender, room->frames++));
    } else if (mavlink::is<mavlink::MissionAck>(frame)) {
      carried_over = mavlink::decode<mavlink::MissionAck>(frame).type;
    } else if (mavlink::is<mavlink::MissionItemReached>(frame)) {
      reached.push_back(mavlink::decode<mavlink::MissionItemReached>(frame).seq);
    } else if (mavlink::is<mavlink::MissionCurrent>(frame)) {
      mission_state = mavlink::decode<mavlink::MissionCurrent>(frame).mission_state;
    } else if (mavlink::is<mavlink::ParamValue>(frame)) {
      const auto value = mavlink::decode<mavlink::ParamValue>(frame);
      parameters[std::string(value.param_id.data(), strnlen(value.param_id.data(), value.param_id.size()))] =
          value.param_value;
    }
  }
  void adds(const Place& place, float radius_m = 0.F) {
    mission.push_back({.param2 = radius_m,
                       .param4 = std::nanf(""),
                       .x = static_cast<std::int32_t>(std::lround(place.x * 1e4)),
                       .y = static_cast<std::int32_t>(std::lround(place.y * 1e4)),
                       .z = static_cast<float>(place.z),
                       .seq = static_cast<std::uint16_t>(mission.size()),
                       .command = 16,
                       .target_system = 1,
                       .frame = 1,
                       .autocontinue = 1});
  }
  /// Again and again, as packets are lost.
  bool carries_over() {
    carried_over.reset();
    int rounds = 0;
    return hears([&] {
      if (!carried_over && rounds++ % 200 == 0) {
        (void)room->send(mavlink::encode(
            mavlink::MissionCount{.count = static_cast<std::uint16_t>(mission.size()), .target_system = 1},
            Room::kSender, room->frames++));
      }
      return carried_over.has_value();
    });
  }
  bool starts(std::vector<std::string> more = {}) {
    room->start_autopilot(events);
    std::vector<std::string> words{"fly",
                                   "--port",
                                   room->port(),
                                   "--pose-port",
                                   room->pose_port(),
                                   "--mavlink-key",
                                   key_file(Room::key_text()).string(),
                                   "--vehicle",
                                   vehicle.string(),
                                   "--gains",
                                   table.string(),
                                   "--flight",
                                   flight_file.string(),
                                   "--json",
                                   result.string(),
                                   "--log",
                                   log.string()};
    words.insert(words.end(), more.begin(), more.end());
    return room->start(words, errors);
  }
  /// Until the room has heard it; what m100 says comes from a thread that lives in the machine's time.
  bool hears(const std::function<bool()>& condition) {
    constexpr int kRounds = 3000;
    for (int round = 0; round < kRounds && !condition(); ++round) {
      (void)room->run_until([] { return false; }, 0.05);
      usleep(5000);
    }
    return condition();
  }
  /// Again and again, as packets are lost, until it is answered.
  bool orders(std::uint16_t command, float param1) {
    answers.erase(command);
    return hears([&] {
      if (answers.count(command) == 0) {
        (void)room->send(mavlink::encode(mavlink::CommandLong{.param1 = param1, .command = command, .target_system = 1},
                                         Room::kSender, room->frames++));
      }
      return answers.count(command) > 0;
    });
  }
  void flies_to(const Place& goal) {
    for (int second = 0; second < 12; ++second) {
      (void)room->send(goal_frame(goal, room->frames++));  // a goal that is repeated is one goal
      (void)room->run_until([] { return false; }, 1.0);
    }
    EXPECT_LT(distance(truth, goal), kAtCorner_m) << "at " << truth.x << " " << truth.y << " " << truth.z;
  }
};

TEST_F(GoalsFlight, ASquareByGoalsAndTheStateReadBack) {
  ASSERT_TRUE(starts()) << error();
  ASSERT_TRUE(hears([&] { return attitudes > 0 && battery >= 0; })) << "it speaks before it flies";
  EXPECT_EQ(base_mode & kArmed, 0);
  const Place start = truth;
  (void)room->send(goal_frame({start.x + 1.0, start.y, start.z}, room->frames++));
  (void)room->run_until([] { return false; }, 2.0);
  ASSERT_TRUE(orders(kGuidedEnable, 1.F));
  EXPECT_EQ(answers[kGuidedEnable], 0);
  ASSERT_TRUE(hears([&] { return (base_mode & kArmed) != 0; })) << "it has control";
  (void)room->run_until([] { return false; }, 3.0);
  EXPECT_LT(distance(truth, start), 0.3) << "a goal from before the flight moves nothing";
  for (const Place& corner : {Place{start.x + 1.0, start.y, start.z}, Place{start.x + 1.0, start.y + 1.0, start.z},
                              Place{start.x, start.y + 1.0, start.z - 0.5}, start}) {
    flies_to(corner);
    const double before_s = room->now_s();
    const std::uint64_t heard = attitudes;
    ASSERT_TRUE(hears([&] { return attitudes > heard && room->now_s() > before_s + 0.3; }));
    EXPECT_NEAR(position.x, corner.x, kAtCorner_m);
    EXPECT_NEAR(position.y, corner.y, kAtCorner_m);
    EXPECT_NEAR(position.z, corner.z, kAtCorner_m);
  }
  EXPECT_GT(estimates, 0U);
  EXPECT_NE(said.find("ladder: silent to nominal"), std::string::npos) << said;
  EXPECT_TRUE(orders(kLand, 0.F));
  EXPECT_EQ(answers[kLand], 3) << "unsupported";
  EXPECT_TRUE(hears([&] { return said.find("land, refused: this program does not have it") != std::string::npos; }))
      << said;
  EXPECT_EQ(room->wrongly_signed, 0U);
  // Released by order: the operator's word, so the flight is over.
  for (int tries = 0; tries < 30 && !room->ended(); ++tries) {
    (void)room->send(mavlink::encode(mavlink::CommandLong{.command = kGuidedEnable, .target_system = 1}, Room::kSender,
                                     room->frames++));
    (void)room->run_until([] { return false; }, 0.3);
  }
  ASSERT_EQ(room->run_to_end(30.0), 0) << error();
  EXPECT_TRUE(json::parse(std::ifstream(result))["released"]);
  EXPECT_EQ(run({"replay", log.string()}), 0) << "goals and all: " << error();
}

// Carried over through a network that loses, doubles and reorders 5 % of the packets, and flown: two points in passing,
// one beyond the fence, and back.
TEST_F(GoalsFlight, AMissionIsCarriedOverFlownAndReplayed) {
  ASSERT_TRUE(starts({"--take-control", "--once", "--hold", "3000"})) << error();
  ASSERT_TRUE(hears([&] { return (base_mode & kArmed) != 0; })) << error();
  (void)room->run_until([] { return false; }, 3.0);
  const Place start = truth;
  double farthest_m = 0.0;
  room->on_pose = [this, &farthest_m, start, before = room->on_pose](const mavlink::AttPosMocap& seen) {
    before(seen);
    farthest_m = std::max(farthest_m, truth.x - start.x);
  };
  adds({start.x + 1.0, start.y, start.z}, 0.5F);
  adds({start.x + 2.0, start.y + 1.0, start.z}, 0.5F);
  adds({start.x + 90.0, start.y + 1.0, start.z});
  adds(start);
  ASSERT_TRUE(carries_over());
  EXPECT_EQ(carried_over, 0);
  (void)room->run_until([] { return false; }, 2.0);
  EXPECT_LT(distance(truth, start), 0.3) << "a mission that is only carried over moves nothing";
  ASSERT_TRUE(orders(kMissionStart, 0.F));
  EXPECT_EQ(answers[kMissionStart], 0);
  ASSERT_TRUE(hears([&] { return mission_state == 5; })) << "complete; reached " << reached.size();
  (void)room->run_until([] { return false; }, 2.0);
  EXPECT_GT(farthest_m, 3.5) << "it flies to the side of the fence";
  EXPECT_LT(farthest_m, 5.0) << "and not beyond it: fence.x_m ends at 5 m";
  EXPECT_LT(distance(truth, start), kAtCorner_m);
  EXPECT_EQ(room->wrongly_signed, 0U);
  room->signal(SIGINT);
  ASSERT_EQ(room->run_to_end(90.0), 0) << error();
  EXPECT_EQ(run({"replay", log.string()}), 0) << "the mission is in the bytes: " << error();
}

TEST_F(GoalsFlight, ParametersAreReadByWhoHasTheKey) {
  ASSERT_TRUE(starts({"--once"})) << error();
  ASSERT_TRUE(hears([&] { return attitudes > 0; }));
  int rounds = 0;
  ASSERT_TRUE(hears([&] {
    if (rounds++ % 200 == 0) {
      (void)room->send(mavlink::encode(mavlink::ParamRequestList{.target_system = 1}, Room::kSender, room->frames++));
    }
    return parameters.count("FENCE_X_LOW_M") > 0 && parameters.count("TILT_LIMIT_RAD") > 0;
  })) << parameters.size();
  EXPECT_NEAR(parameters["FENCE_X_HIGH_M"] - parameters["FENCE_X_LOW_M"], 10.0, 1e-4) << "of the flight file";
  room->signal(SIGINT);
  (void)room->run_to_end(30.0);
}

TEST_F(GoalsFlight, NobodysGoalMovesAnythingAndNoGoalLeavesTheFence) {
  ASSERT_TRUE(starts({"--take-control", "--once", "--hold", "40"})) << error();
  ASSERT_TRUE(hears([&] { return (base_mode & kArmed) != 0; })) << error();
  (void)room->run_until([] { return false; }, 3.0);
  const Place start = truth;
  // Unsigned, with another key, and changed on its way.
  mavlink::Key other = Room::kKey;
  other.front() ^= std::byte{1};
  for (int i = 0; i < 100; ++i) {
    mavlink::Frame forged = goal_frame({start.x + 2.0, start.y, start.z}, room->frames);
    room->send_as_stranger(forged.bytes());
    mavlink::sign(forged, other, Room::kLink, room->stamp());
    room->send_as_stranger(forged.bytes());
    (void)room->run_until([] { return false; }, 0.05);
  }
  EXPECT_LT(distance(truth, start), 0.3);
  // Played back: what once was a goal is none again.
  const Place there{start.x - 1.0, start.y, start.z};
  const Packet goal = room->send(goal_frame(there, room->frames++));
  flies_to(there);
  flies_to(start);
  for (int i = 0; i < 60; ++i) {
    room->send_as_stranger(goal);
    (void)room->run_until([] { return false; }, 0.05);
  }
  EXPECT_LT(distance(truth, start), 0.3);
  (void)room->send(goal_frame({start.x + 400.0, start.y, start.z}, room->frames++));
  double farthest_m = 0.0;
  for (int i = 0; i < 200; ++i) {
    (void)room->run_until([] { return false; }, 0.05);
    farthest_m = std::max(farthest_m, truth.x - start.x);
  }
  EXPECT_GT(farthest_m, 3.5) << "it flies to the side of the fence";
  EXPECT_LT(farthest_m, 5.0) << "and not beyond it: fence.x_m ends at 5 m";
  ASSERT_TRUE(room->run_to_end(60.0).has_value());
  const json counts = json::parse(std::ifstream(result))["pose_link"]["signatures"];
  EXPECT_GE(counts["unsigned"], 95);
  EXPECT_GE(counts["wrong"], 95);
  EXPECT_GE(counts["replayed"], 55);
}

}  // namespace
}  // namespace m100::room
