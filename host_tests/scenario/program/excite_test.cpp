// SPDX-License-Identifier: BSD-3-Clause
// m100-lab excite, m100 fly --excite with m100-lab autopilot in simulated time, and m100-lab identify on the log.
#include <cmath>

#include "host_tests/scenario/program/world_fixture.h"
#include "host_tests/sim/world/plant.h"

namespace m100::scenario {
namespace {

class Excite : public WorldTest {
 protected:
  const fs::path sticks = folder / "sticks.csv";
  const fs::path forecast = folder / "forecast.json";

  void make(const std::string& axes, const Words& more) {
    const Words words{"excite", "--axis", axes, "--out", sticks.string(), "--json", forecast.string()};
    ASSERT_LE(run_lab(with(words, more)), 1) << error();  // 1: written, but too small to find more than a trim
  }
  void fence(const std::string& half_m) {
    const std::string side = "_m = [-" + half_m + ", " + half_m + "]\n";
    made("flight.toml", "[fence]\nx" + side + "y" + side + "z_m = [0.3, 6.0]\n");
  }
  /// Flies the sticks. @returns the exit code; writes `result` and `said`.
  int fly(const std::string& script = "", const std::string& plant = "") {
    return fly_in_world(plant, {"--excite", sticks.string(), "--hold", "5"}, scripted(script));
  }
  Json flown() const { return reported()["excitation"]; }
  /// Largest true distance from the start along x or y [m].
  double farthest_m() const {
    double farthest = 0.0;
    for (const Json& event : every_event()) {
      if (event["what"] == "truth") {
        farthest = std::max({farthest, std::abs(event["x_m"].get<double>()), std::abs(event["y_m"].get<double>())});
      }
    }
    return farthest;
  }
};

TEST_F(Excite, IsFlownStickByStickAndItsLogIsIdentified) {
  make("roll,pitch", {"--duration", "40", "--amplitude", "150"});
  fence("12");
  ASSERT_EQ(fly(), 0) << error() << text_of(said);
  const Json excitation = flown();
  EXPECT_EQ(excitation["over"], true);
  EXPECT_EQ(excitation["flown"], excitation["pieces"]);
  EXPECT_NE(text_of(said).find("pieces are flown"), std::string::npos) << text_of(said);
  EXPECT_EQ(run({"replay", log.string()}), 0) << error();

  const sim::Plant plant = sim::measured_plant();
  const std::string within =
      std::to_string(excitation["from_s"].get<double>()) + ":" + std::to_string(excitation["to_s"].get<double>());
  for (const auto& [axis, truth] : {std::pair{"roll", plant.roll}, std::pair{"pitch", plant.pitch}}) {
    const fs::path answer = folder / (std::string(axis) + ".json");
    ASSERT_EQ(run_lab({"identify", "--log", log.string(), "--columns", std::string(M100_MAPS) + "/m100_log.toml",
                       "--axis", axis, "--declare", "second_order,transport_delay,dead_zone,trim_offset", "--split",
                       "alternate:6", "--within", within, "--forecast", forecast.string(), "--json", answer.string()}),
              0)
        << error();
    const Json whole = Json::parse(text_of(answer));
    const Json found = whole["final"]["parameters"];
    EXPECT_NEAR(found["natural_frequency_rad_s"].get<double>(), truth.natural_frequency_rad_s,
                0.15 * truth.natural_frequency_rad_s);
    EXPECT_NEAR(found["damping_ratio"].get<double>(), truth.damping_ratio, 0.15);
    EXPECT_NEAR(found["width_counts"].get<double>(), truth.dead_zone_counts, 5.0);
    EXPECT_NE(whole["forecast"]["text"].get<std::string>().find("dead_zone is known to a standard deviation of"),
              std::string::npos)
        << whole["forecast"];
  }
}

TEST_F(Excite, IsAbortedBeforeTheFenceAndTheLawHoldsThePlace) {
  RecordProperty("promise", "R16");
  make("roll", {"--duration", "40", "--amplitude", "300", "--fence", "30"});
  fence("3");
  EXPECT_EQ(fly(), 2) << "sticks made for a larger room are accepted";
  EXPECT_NE(error().find("its roll may take the aircraft 30 m from the start, but"), std::string::npos) << error();
  EXPECT_NE(error().find("fence ends after 3 m"), std::string::npos) << error();
  std::string by_hand = text_of(sticks);  // a file whose movement exceeds its promise
  const std::string limit = "distance 30 braking 2";
  ASSERT_NE(by_hand.find(limit), std::string::npos) << by_hand.substr(0, 400);
  by_hand.replace(by_hand.find(limit), limit.size(), "distance 3 braking 900");
  made("sticks.csv", by_hand);
  EXPECT_EQ(fly(), 1) << "expected for an aborted excitation";
  const Json excitation = flown();
  EXPECT_EQ(excitation["aborted"], true);
  EXPECT_EQ(excitation["abort"]["why"], "fence");
  EXPECT_NE(text_of(said).find("the aircraft would stop beyond the fence"), std::string::npos) << text_of(said);
  EXPECT_LT(farthest_m(), 3.0);
  const Json whole = reported();
  EXPECT_EQ(whole["released"], true);
  EXPECT_NEAR(whole["position_m"][1].get<double>(), 0.0, 0.5) << "must be back at its position five seconds later";
}

// The limits that the file states for its own stick, one after the other set far below what its movement needs.
TEST_F(Excite, IsAbortedByItsOwnLimitsAndTheLawHoldsThePlace) {
  RecordProperty("promise", "R16");
  make("roll", {"--duration", "40", "--amplitude", "150"});
  fence("12");
  const std::string whole_room = text_of(sticks);
  for (const auto& [why, narrow] : {std::pair{"distance", "distance 0.5 braking 2 speed 6 tilt 0.5"},
                                    std::pair{"speed", "distance 8 braking 2 speed 0.4 tilt 0.5"},
                                    std::pair{"tilt", "distance 8 braking 2 speed 6 tilt 0.05"}}) {
    SCOPED_TRACE(why);
    const std::size_t begin = whole_room.find("limits roll ");
    ASSERT_NE(begin, std::string::npos);
    made("sticks.csv",
         whole_room.substr(0, begin) + "limits roll " + narrow + whole_room.substr(whole_room.find('\n', begin)));
    EXPECT_EQ(fly(), 1) << "expected for an aborted excitation";
    const Json excitation = flown();
    EXPECT_EQ(excitation["abort"]["why"], why);
    EXPECT_LT(farthest_m(), 2.5);
    const Json whole = reported();
    EXPECT_EQ(whole["released"], true);
    EXPECT_NEAR(whole["position_m"][1].get<double>(), 0.0, 0.5) << "must be back at its position five seconds later";
  }
}

// The guide's room and its command, with wind, wrong trims and drag. Catches sticks centred on the vehicle file's
// trims, and movements without a reserve for disturbances: both ended this flight at its third piece.
// soak.excitation_space covers many seeds and long delays.
TEST_F(Excite, IsFlownToItsEndInTheGuidesRoom) {
  make("roll,pitch", {"--duration", "40", "--amplitude", "150", "--fence", "3"});
  fs::copy_file(M100_FLIGHT_FILE, flight_file, fs::copy_options::overwrite_existing);
  const sim::Plant plant = sim::measured_plant();
  ASSERT_EQ(fly("", "[air]\nlinear_drag_per_s = 0.3\nwind_m_s = [2.1, -2.1, 0.0]\n[axis.roll]\ntrim_counts = " +
                        std::to_string(plant.roll.trim_counts + 20.0) +
                        "\n[axis.pitch]\ntrim_counts = " + std::to_string(plant.pitch.trim_counts - 20.0) + "\n"),
            0)
      << error() << text_of(said);
  EXPECT_EQ(flown()["over"], true) << flown();
  EXPECT_LT(farthest_m(), 3.0);
}

TEST_F(Excite, EndsWithThePilotsSwitch) {
  make("roll", {"--duration", "40", "--amplitude", "150"});
  fence("12");
  EXPECT_EQ(fly("12 mode P\n"), 1);
  const Json excitation = flown();
  EXPECT_EQ(excitation["abort"]["why"], "failsafe");
  EXPECT_NE(text_of(said).find("on roll: control is lost"), std::string::npos) << text_of(said);
}

TEST_F(Excite, RefusesWhatItCannotFly) {
  make("climb", {"--duration", "20"});
  fence("12");
  const auto autopilot = start_autopilot();
  EXPECT_EQ(run(flight({"--excite", made("bad.csv", "t_s,stick_roll\n0,1\n")})), 2);
  EXPECT_NE(error().find("bad.csv:1: needs the columns t_s, piece"), std::string::npos) << error();
  EXPECT_EQ(run(flight({"--excite", sticks.string(), "--channel", "movement"})), 2);
  EXPECT_NE(error().find("needs --channel virtual_rc"), std::string::npos) << error();
  EXPECT_EQ(fly(), 2) << "2 m down from 1.5 m would leave the fence";
  EXPECT_NE(error().find("leaves"), std::string::npos) << error();
}

}  // namespace
}  // namespace m100::scenario
