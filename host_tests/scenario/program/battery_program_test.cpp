// SPDX-License-Identifier: BSD-3-Clause
// A battery that becomes low in flight, with both programs in simulated time: the operator is told, the aircraft
// returns inside the fence, and the pilot gets control. The emulated battery loses one percent in 8.4 s.
#include <cmath>

#include "firmware/companion/files/recorded_flight.h"
#include "host_tests/scenario/program/world_fixture.h"

namespace m100::scenario {
namespace {

constexpr const char* kTired = "[battery]\nstart_percent = 23.0\n";

class BatteryLow : public WorldTest {
 protected:
  int fly_away(const std::string& plant, const std::string& hold_s, const std::string& script = "") {
    const std::string course = made("away", "step 0 0 0 0 1\nstep 2 1 0.5 0 60\n");
    return fly_in_world(plant, {"--course", course, "--hold", hold_s}, scripted(script));
  }
  /// Distance, this many seconds before the end, from the position 4 s after the beginning, where it hovered while
  /// control was requested.
  double away_m(double before_end_s) const {
    const auto ticks = companion::read_flight(log.string()).ticks;
    const auto back = static_cast<std::size_t>(100.0 * before_end_s);
    const auto& from = ticks.at(400).record.position;
    const auto& to = ticks.at(ticks.size() - 1 - back).record.position;
    return std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
  }
};

TEST_F(BatteryLow, IsSaidBroughtHomeAndHandedOver) {
  EXPECT_EQ(fly_away(kTired, "60"), 1) << "exit code for a flight that was not flown as ordered";
  EXPECT_NE(all_said().find("battery low: 20 %, the limit is 20 %; the aircraft flies to where the flight began"),
            std::string::npos)
      << all_said();
  EXPECT_NE(all_said().find("control goes back to the transmitter"), std::string::npos) << all_said();
  EXPECT_EQ(all_said().find("coast"), std::string::npos) << all_said();
  EXPECT_GT(away_m(8.0), 1.5) << "the aircraft did not follow its course before";
  EXPECT_LT(away_m(0.0), 0.5);
  EXPECT_EQ(run({"replay", log.string()}), 0) << "the replay differs: " << error();
}

// Regression test: a charge of zero counted as not reported, even in the middle of a flight.
TEST_F(BatteryLow, IsNoticedWhereTheChargeFallsToNoughtAtOnce) {
  RecordProperty("promise", "R14");
  EXPECT_EQ(fly_away("", "60", "18 lie battery 0\n"), 1);
  EXPECT_NE(all_said().find("battery low: 0 %"), std::string::npos) << all_said();
  EXPECT_LT(away_m(0.0), 0.5);
}

TEST_F(BatteryLow, IsNobodysBusinessWhereTheFlightFileSaysSo) {
  const std::string text = text_of(flight_file);
  made("flight.toml", text.substr(0, text.find("[battery]")) + "\n[battery]\nlow_percent = 0\n");
  EXPECT_EQ(fly_away(kTired, "25"), 0) << error();
  EXPECT_EQ(all_said().find("battery"), std::string::npos) << all_said();
}

}  // namespace
}  // namespace m100::scenario
