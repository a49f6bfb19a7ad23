// SPDX-License-Identifier: BSD-3-Clause
// The room controls m100: it engages by an order, flies a square by goals and reads the state back. Another sender
// cannot move the aircraft.
#include "host_tests/scenario/room/room_flight.h"

namespace m100::room {
namespace {

using scenario::json;

using GoalsFlight = RoomFlight;

TEST_F(GoalsFlight, ASquareByGoalsAndTheStateReadBack) {
  ASSERT_TRUE(starts()) << error();
  ASSERT_TRUE(hears([&] { return attitudes > 0 && battery >= 0; })) << "no state was sent before the flight";
  EXPECT_EQ(base_mode & kArmed, 0);
  const Place start = truth;
  (void)room->send(goal_frame({start.x + 1.0, start.y, start.z}, room->frames++));
  (void)room->run_until([] { return false; }, 2.0);
  ASSERT_TRUE(orders(kGuidedEnable, 1.F));
  EXPECT_EQ(answers[kGuidedEnable], 0);
  ASSERT_TRUE(hears([&] { return (base_mode & kArmed) != 0; })) << "the aircraft is not reported as armed";
  (void)room->run_until([] { return false; }, 3.0);
  EXPECT_LT(distance(truth, start), 0.3) << "a goal from before the flight moved the aircraft";
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
  EXPECT_TRUE(orders(kReturnHome, 0.F));
  EXPECT_EQ(answers[kReturnHome], 3) << "unsupported";
  EXPECT_TRUE(hears([&] {
    return said.find("command 20, refused: this program does not support it") != std::string::npos;
  })) << said;
  EXPECT_EQ(room->wrongly_signed, 0U);
  // The order to release counts as the operator's, so it ends the flight.
  for (int tries = 0; tries < 30 && !room->ended(); ++tries) {
    (void)room->send(mavlink::encode(mavlink::CommandLong{.command = kGuidedEnable, .target_system = 1}, Room::kSender,
                                     room->frames++));
    (void)room->run_until([] { return false; }, 0.3);
  }
  ASSERT_EQ(room->run_to_end(30.0), 0) << error();
  EXPECT_TRUE(json::parse(std::ifstream(result))["released"]);
  EXPECT_EQ(run({"replay", log.string()}), 0) << "the log with goals does not replay: " << error();
}

// A mission, transferred through a network that loses, doubles and reorders 5 % of the packets, and flown: two points
// in passing, one beyond the fence, and back.
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
  EXPECT_LT(distance(truth, start), 0.3) << "a mission moved the aircraft before its start";
  ASSERT_TRUE(orders(kMissionStart, 0.F));
  EXPECT_EQ(answers[kMissionStart], 0);
  ASSERT_TRUE(hears([&] { return mission_state == 5; })) << "complete; reached " << reached.size();
  (void)room->run_until([] { return false; }, 2.0);
  EXPECT_GT(farthest_m, 3.5) << "must fly to the limit of the fence";
  EXPECT_LT(farthest_m, 5.0) << "must not fly beyond it: fence.x_m ends at 5 m";
  EXPECT_LT(distance(truth, start), kAtCorner_m);
  EXPECT_EQ(room->wrongly_signed, 0U);
  room->signal(SIGINT);
  ASSERT_EQ(room->run_to_end(90.0), 0) << error();
  EXPECT_EQ(run({"replay", log.string()}), 0) << "the log with the mission does not replay: " << error();
}

TEST_F(GoalsFlight, NobodysGoalMovesAnythingAndNoGoalLeavesTheFence) {
  ASSERT_TRUE(starts({"--take-control", "--once", "--hold", "40"})) << error();
  ASSERT_TRUE(hears([&] { return (base_mode & kArmed) != 0; })) << error();
  (void)room->run_until([] { return false; }, 3.0);
  const Place start = truth;
  // Goals: unsigned, with another key, and changed on the way.
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
  // Replayed: a recorded goal must not count a second time.
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
  EXPECT_GT(farthest_m, 3.5) << "must fly to the limit of the fence";
  EXPECT_LT(farthest_m, 5.0) << "must not fly beyond it: fence.x_m ends at 5 m";
  ASSERT_TRUE(room->run_to_end(60.0).has_value());
  const json counts = json::parse(std::ifstream(result))["pose_link"]["signatures"];
  EXPECT_GE(counts["unsigned"], 95);
  EXPECT_GE(counts["wrong"], 95);
  EXPECT_GE(counts["replayed"], 55);
}

}  // namespace
}  // namespace m100::room
