// SPDX-License-Identifier: BSD-3-Clause
// SensorFaults with the two shipped programs in simulated time: the messages to the operator, and the distance of the
// aircraft until the pilot has control.
#include <algorithm>
#include <cmath>

#include "host_tests/scenario/program/world_fixture.h"

namespace m100::scenario {
namespace {

constexpr double kStruckAt_s = 18.0;

struct FaultFlown {
  const char* name;
  const char* script;  ///< script of the autopilot
  const char* said;    ///< a message to the operator
  double within_m;     ///< distance from the start until the transmitter has control: the value of THREATS.md plus 50 %
};

class SensorFaults : public WorldTest, public ::testing::WithParamInterface<FaultFlown> {};

TEST_P(SensorFaults, AreSaidByNameAndEndWithThePilot) {
  RecordProperty("promise", "R14");
  const FaultFlown& fault = GetParam();
  EXPECT_EQ(fly_in_world("", {"--hold", "60"}, scripted(fault.script)), 1) << error();
  EXPECT_NE(all_said().find(fault.said), std::string::npos) << all_said();
  double from_m[2] = {}, farthest_m = 0.0;
  bool struck = false, handed = false;
  for (const Json& event : every_event()) {
    handed = handed || (struck && event.value("name", "") == "transmitter_has_control");
    if (event.value("what", "") != "truth" || event["t_s"] < kStruckAt_s || handed) {
      continue;
    }
    const double x_m = event["x_m"].get<double>(), y_m = event["y_m"].get<double>();
    from_m[0] = struck ? from_m[0] : x_m;
    from_m[1] = struck ? from_m[1] : y_m;
    struck = true;
    farthest_m = std::max(farthest_m, std::hypot(x_m - from_m[0], y_m - from_m[1]));
  }
  EXPECT_TRUE(struck) << "the program did not command when the sensor fault began";
  EXPECT_LE(farthest_m, fault.within_m);
  EXPECT_FALSE(summary()["client_in_control"].get<bool>());
  EXPECT_EQ(summary()["control_after_loss"], 0);
}
INSTANTIATE_TEST_SUITE_P(Flown, SensorFaults,
                         ::testing::Values(FaultFlown{"Standing", "18 lie standing\n", "contradicts it, check ", 3.1},
                                           FaultFlown{"Mirror", "18 lie mirror\n", "contradicts it, check ", 0.75},
                                           FaultFlown{"Drift", "18 lie drift\n", "contradicts it, check ", 0.35},
                                           FaultFlown{"RollInverted", "18 lie roll_inverted\n",
                                                      "attitude refused: ", 0.15}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace m100::scenario
