// SPDX-License-Identifier: BSD-3-Clause
// Take-off and landing by signed orders of the room, and parameters that it may read but not write.
#include "host_tests/scenario/ground_station/ground_station_flight.h"

namespace m100::ground_station {
namespace {

using scenario::json;

using GroundStationOrdersFlight = GroundStationFlight;

/// Sends an unsigned broadcast command, from a sender without the key.
void send_unsigned(GroundStation& ground_station, std::uint16_t command) {
  ground_station.send_unauthorized(mavlink::encode(mavlink::CommandLong{.param1 = 1.F, .command = command},
                                                   GroundStation::kSender, ground_station.frames)
                                       .bytes());
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
  const json flown = json::parse(std::ifstream(result));
  EXPECT_EQ(flown["landed"], true);
  EXPECT_EQ(flown["released"], true);
  EXPECT_EQ(run({"replay", log.string()}), 0) << "the log with orders does not replay: " << error();
}

TEST_F(GroundStationOrdersFlight, ParametersAreReadByWhoHasTheKey) {
  ASSERT_TRUE(start_flight({"--once"})) << error();
  ASSERT_TRUE(receive_until([&] { return attitudes > 0; }));
  int rounds = 0;
  ASSERT_TRUE(receive_until([&] {
    if (rounds++ % 200 == 0) {
      (void)ground_station->send(mavlink::encode(mavlink::ParamRequestList{.target_system = 1}, GroundStation::kSender,
                                                 ground_station->frames++));
    }
    return parameters.count("FENCE_X_LOW_M") > 0 && parameters.count("TILT_LIMIT_RAD") > 0;
  })) << parameters.size();
  EXPECT_NEAR(parameters["FENCE_X_HIGH_M"] - parameters["FENCE_X_LOW_M"], 10.0, 1e-4)
      << "size of the fence in the flight file";
  // An attempt to write a parameter is answered with the unchanged value, and reported.
  mavlink::ParamSet wish{.param_value = 99.F, .target_system = 1, .param_id = {'M', 'A', 'S', 'S', '_', 'K', 'G'}};
  const float mass_kg = parameters["MASS_KG"];
  parameters.clear();
  ASSERT_TRUE(receive_until([&] {
    (void)ground_station->send(mavlink::encode(wish, GroundStation::kSender, ground_station->frames++));
    return parameters.count("MASS_KG") > 0;
  }));
  EXPECT_EQ(parameters["MASS_KG"], mass_kg);
  EXPECT_TRUE(receive_until([&] { return said.find("parameter MASS_KG: not set") != std::string::npos; })) << said;
  ground_station->signal(SIGINT);
  (void)ground_station->run_to_end(30.0);
  EXPECT_GE(json::parse(std::ifstream(result))["ground_station"]["parameters_not_set"], 1);
}

}  // namespace
}  // namespace m100::ground_station
