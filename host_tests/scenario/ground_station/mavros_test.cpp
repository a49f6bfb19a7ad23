// SPDX-License-Identifier: BSD-3-Clause
// MAVROS on the board: unsigned poses and goals over the loopback, from the named sender and from nobody else.
#include "host_tests/scenario/ground_station/mavros_stand_in.h"

namespace m100::ground_station {
namespace {

constexpr std::uint16_t kPlaceAndYaw = 2552;  ///< type_mask of setpoint_position

mavlink::SetPositionTargetLocalNed set_point(const Place& place) {
  return {.x = static_cast<float>(place.x),
          .y = static_cast<float>(place.y),
          .z = static_cast<float>(place.z),
          .type_mask = kPlaceAndYaw,
          .target_system = 1,
          .target_component = 1,
          .coordinate_frame = 1};
}

struct LoopbackFlight : MavrosTest {};

// While MAVROS flies it, false poses come from another program, under MAVROS' own number from another address of this
// machine, and goals and orders from whoever reaches the loopback, as through a ground-station proxy.
TEST_F(LoopbackFlight, PosesOfTheNamedSenderAreFlownAndNothingElseMovesTheAircraft) {
  const Socket elsewhere(INADDR_LOOPBACK + 1);
  const auto number = static_cast<std::uint16_t>(std::stoi(ground_station->pose_port().substr(4)));
  ground_station->on_pose = [&](const mavlink::AttPosMocap& seen) {
    mavlink::AttPosMocap wrong = seen;
    wrong.x += 2.F;
    wrong.time_usec = static_cast<std::uint64_t>(clock_us());
    elsewhere.send(number, mavlink::encode(wrong, kMavros, numbers).bytes());
    take(seen);
    send(wrong, {.system = 1, .component = 197});
    if (poses % 20 == 0) {
      send(set_point({truth.x + 2.0, truth.y, truth.z}));
      send(set_point({truth.x + 2.0, truth.y, truth.z}), {.system = 255, .component = 190});
      send(mavlink::CommandLong{.param1 = 0.F, .command = kGuidedEnable, .target_system = 1},
           {.system = 255, .component = 190});
    }
  };
  ASSERT_TRUE(start({"--hold", "8"})) << error();
  const std::optional<int> code = ground_station->run_to_end(60.0);
  ASSERT_EQ(code, 0) << error();
  const Json flown = reported();
  EXPECT_NEAR(flown["position_m"][0].get<double>(), 0.0, 0.5);
  for (const Json& sender : flown["pose"]["senders"]) {
    EXPECT_EQ(sender[0], 1) << sender;
  }
  EXPECT_GT(flown["pose"]["refused"].value("sender", 0), 700) << flown["pose"];
  EXPECT_EQ(answers[kGuidedEnable], 2) << "an order without a signature is denied";
  EXPECT_NE(said.find("only the sender of --set-points-from counts"), std::string::npos) << said;
  EXPECT_GT(time_questions, 20U);
  EXPECT_GT(time_answers, 50U);
  EXPECT_GT(heartbeats, 3U);
  EXPECT_GT(attitudes, 30U);
  EXPECT_EQ(run({"replay", log.string()}), 0) << error();
}

TEST_F(LoopbackFlight, OdometryAndSetPointsOfTheNamedSenderAreFlown) {
  sends_odometry = true;
  ASSERT_TRUE(start({"--hold", "30", "--set-points-from", "1:240"})) << error();
  ASSERT_TRUE(receive_until([&] { return (base_mode & kArmed) != 0; })) << error();
  pass(2.0);
  const Place begin = truth;
  send(set_point({begin.x - 2.0, begin.y, begin.z}), {.system = 255, .component = 190});
  pass(4.0);
  EXPECT_LT(distance(truth, begin), 0.3) << "a set point of another sender moved the aircraft";
  const Place goal{begin.x + 1.0, begin.y - 1.0, begin.z - 0.5};
  for (int repeated = 0; repeated < 160; ++repeated) {  // as setpoint_position does, 20 a second
    send(set_point(goal));
    pass(0.05);
  }
  EXPECT_LT(distance(truth, goal), kAtCorner_m) << truth.x << " " << truth.y << " " << truth.z;
  for (int sent = 0; sent <= 60; ++sent) {  // as setpoint_velocity does: 0.3 m/s to the north for three seconds
    mavlink::SetPositionTargetLocalNed velocity = set_point({});
    velocity.time_boot_ms = static_cast<std::uint32_t>(clock_us() / 1000);
    velocity.vx = 0.3F;
    velocity.type_mask = 1479;
    send(velocity);
    pass(0.05);
  }
  pass(2.0);
  EXPECT_NEAR(truth.x, goal.x + 0.9, 0.3);
  EXPECT_NEAR(truth.y, goal.y, kAtCorner_m);
  EXPECT_NE(said.find("it brakes and holds"), std::string::npos) << said;
  ASSERT_EQ(ground_station->run_to_end(60.0), 0) << error();
  EXPECT_EQ(run({"replay", log.string()}), 0) << "the log with a stream does not replay: " << error();
}

TEST_F(LoopbackFlight, EachWrongCombinationIsRefusedByOneSentenceInEveryCommand) {
  const auto refused = [&](const Words& source, const std::string& because) {
    for (const Words& command : {Words{"fly", "--port", ground_station->port(), "--dry-run"},
                                 Words{"record", "--port", ground_station->port(), "--log", log.string()}}) {
      EXPECT_EQ(run(with(command, source)), 2);
      const std::string text = error();
      EXPECT_NE(text.find(because), std::string::npos) << text;
      EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    }
    const Words words{"doctor", "--load", "0", "--folder", folder.string(), "--json", result.string()};
    EXPECT_EQ(run(with(words, source)), 1);
    EXPECT_NE(scenario::text_of(result).find(because), std::string::npos);
    EXPECT_EQ(run_lab(with({"evening", path("evening"), "--port", ground_station->port()}, source)), 2);
    EXPECT_NE(error().find(because), std::string::npos) << error();
  };
  refused({"--pose-port", loopback_port()}, "unsigned poses need --pose-from");
  refused({"--pose-port", ground_station->pose_port(), "--pose-from", "1:240"}, "must be signed");
  refused({"--pose-port", loopback_port(), "--mavlink-key", key, "--set-points-from", "1:240"},
          "every holder of the key");
  refused({"--pose-port", "udp:127.0.0.2:14560", "--pose-from", "1"}, "a UDP port is written udp:PORT");
}

}  // namespace
}  // namespace m100::ground_station
