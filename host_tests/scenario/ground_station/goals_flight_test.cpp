// SPDX-License-Identifier: BSD-3-Clause
// The room controls m100: it engages by an order, flies a square by goals and reads the state back. Another sender
// cannot move the aircraft.
#include "host_tests/scenario/ground_station/ground_station_flight.h"

namespace m100::ground_station {
namespace {

using GoalsFlight = GroundStationFlight;

TEST_F(GoalsFlight, ASquareByGoalsAndTheStateReadBack) {
  ASSERT_TRUE(start_flight()) << error();
  ASSERT_TRUE(receive_until([&] { return attitudes > 0 && battery >= 0; })) << "no state was sent before the flight";
  EXPECT_EQ(base_mode & kArmed, 0);
  const Place start = truth;
  (void)ground_station->send(goal_frame({start.x + 1.0, start.y, start.z}, ground_station->frames++));
  (void)ground_station->run_until([] { return false; }, 2.0);
  ASSERT_TRUE(send_command(kGuidedEnable, 1.F));
  EXPECT_EQ(answers[kGuidedEnable], 0);
  ASSERT_TRUE(receive_until([&] { return (base_mode & kArmed) != 0; })) << "the aircraft is not reported as armed";
  (void)ground_station->run_until([] { return false; }, 3.0);
  EXPECT_LT(distance(truth, start), 0.3) << "a goal from before the flight moved the aircraft";
  for (const Place& corner : {Place{start.x + 1.0, start.y, start.z}, Place{start.x + 1.0, start.y + 1.0, start.z},
                              Place{start.x, start.y + 1.0, start.z - 0.5}, start}) {
    fly_to(corner);
    const double before_s = ground_station->now_s();
    const std::uint64_t heard = attitudes;
    ASSERT_TRUE(receive_until([&] { return attitudes > heard && ground_station->now_s() > before_s + 0.3; }));
    EXPECT_NEAR(position.x, corner.x, kAtCorner_m);
    EXPECT_NEAR(position.y, corner.y, kAtCorner_m);
    EXPECT_NEAR(position.z, corner.z, kAtCorner_m);
  }
  EXPECT_GT(estimates, 0U);
  EXPECT_NE(said.find("failsafe: silent to nominal"), std::string::npos) << said;
  EXPECT_TRUE(send_command(kReturnHome, 0.F));
  EXPECT_EQ(answers[kReturnHome], 3) << "unsupported";
  EXPECT_TRUE(receive_until([&] {
    return said.find("command 20, refused: this program does not support it") != std::string::npos;
  })) << said;
  EXPECT_EQ(ground_station->wrongly_signed, 0U);
  // The order to release counts as the operator's, so it ends the flight.
  for (int tries = 0; tries < 30 && !ground_station->ended(); ++tries) {
    (void)ground_station->send(mavlink::encode(mavlink::CommandLong{.command = kGuidedEnable, .target_system = 1},
                                               GroundStation::kSender, ground_station->frames++));
    (void)ground_station->run_until([] { return false; }, 0.3);
  }
  ASSERT_EQ(ground_station->run_to_end(30.0), 0) << error();
  EXPECT_EQ(reported()["released"], true);
  EXPECT_EQ(run({"replay", log.string()}), 0) << "the log with goals does not replay: " << error();
}

TEST_F(GoalsFlight, NobodysGoalMovesAnythingAndNoGoalLeavesTheFence) {
  ASSERT_TRUE(start_flight({"--take-control", "--once", "--hold", "40"})) << error();
  ASSERT_TRUE(receive_until([&] { return (base_mode & kArmed) != 0; })) << error();
  (void)ground_station->run_until([] { return false; }, 3.0);
  const Place start = truth;
  // Goals: unsigned, with another key, and changed on the way.
  mavlink::Key other = GroundStation::kKey;
  other.front() ^= std::byte{1};
  for (int i = 0; i < 100; ++i) {
    mavlink::Frame forged = goal_frame({start.x + 2.0, start.y, start.z}, ground_station->frames);
    ground_station->send_unauthorized(forged.bytes());
    mavlink::sign(forged, other, GroundStation::kLink, ground_station->stamp());
    ground_station->send_unauthorized(forged.bytes());
    (void)ground_station->run_until([] { return false; }, 0.05);
  }
  EXPECT_LT(distance(truth, start), 0.3);
  // Replayed: a recorded goal must not count a second time.
  const Place there{start.x - 1.0, start.y, start.z};
  const Packet goal = ground_station->send(goal_frame(there, ground_station->frames++));
  fly_to(there);
  fly_to(start);
  for (int i = 0; i < 60; ++i) {
    ground_station->send_unauthorized(goal);
    (void)ground_station->run_until([] { return false; }, 0.05);
  }
  EXPECT_LT(distance(truth, start), 0.3);
  (void)ground_station->send(goal_frame({start.x + 400.0, start.y, start.z}, ground_station->frames++));
  double farthest_m = 0.0;
  for (int i = 0; i < 200; ++i) {
    (void)ground_station->run_until([] { return false; }, 0.05);
    farthest_m = std::max(farthest_m, truth.x - start.x);
  }
  EXPECT_GT(farthest_m, 3.5) << "must fly to the limit of the fence";
  EXPECT_LT(farthest_m, 5.0) << "must not fly beyond it: fence.x_m ends at 5 m";
  ASSERT_TRUE(ground_station->run_to_end(60.0).has_value());
  const Json counts = reported()["pose_link"]["signatures"];
  EXPECT_GE(counts["unsigned"], 95);
  EXPECT_GE(counts["wrong"], 95);
  EXPECT_GE(counts["replayed"], 55);
}

}  // namespace
}  // namespace m100::ground_station
