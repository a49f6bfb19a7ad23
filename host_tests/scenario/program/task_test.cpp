// SPDX-License-Identifier: BSD-3-Clause
// Take-off and landing by the autopilot's own tasks, with both programs in simulated time: the requests, the reactions
// of the autopilot, and who has control afterwards.
#include <cmath>
#include <cstdio>
#include <limits>

#include "host_tests/scenario/program/world_fixture.h"

namespace m100::scenario {
namespace {

constexpr double kNever_s = std::numeric_limits<double>::infinity();

class Tasks : public WorldTest {
 protected:
  /// Flies. @returns the exit code; writes events, result and said.
  int fly(const std::vector<std::string>& options, const std::string& script = "", bool on_ground = true,
          const std::string& plant = "") {
    return fly_in_world(plant, options, with(scripted(script), on_ground ? Words{"--on-ground"} : Words{}));
  }
  /// Time of the autopilot's first such event after `from_s` [s].
  double at(const std::string& name, const std::string& what = "did", double from_s = 0.0) const {
    for (const Json& line : every_event()) {
      if (line.value("name", "") == name && line["what"] == what && line["t_s"].get<double>() >= from_s) {
        return line["t_s"].get<double>();
      }
    }
    return kNever_s;
  }
  /// Number of such events.
  long times(const std::string& name, const std::string& what = "received") const {
    const std::vector<Json> all = every_event();
    return std::count_if(all.begin(), all.end(),
                         [&](const Json& line) { return line.value("name", "") == name && line["what"] == what; });
  }
  /// Extremes of a true coordinate between two times.
  std::pair<double, double> range(const std::string& key, double from_s, double to_s) const {
    std::pair<double, double> seen{kNever_s, -kNever_s};
    for (const Json& line : every_event()) {
      if (line["what"] == "truth" && line["t_s"].get<double>() >= from_s && line["t_s"].get<double>() <= to_s) {
        seen = {std::min(seen.first, line[key].get<double>()), std::max(seen.second, line[key].get<double>())};
      }
    }
    return seen;
  }
};

TEST_F(Tasks, TakesOffFliesTheCourseLandsAndGivesControlBackOnTheGround) {
  RecordProperty("promise", "R15");
  ASSERT_EQ(fly({"--take-off", "--land", "--hold", "6"}), 0) << all_said();
  const double off_s = at("taken_off");
  const double down_s = at("landed");
  ASSERT_LT(off_s, kNever_s) << all_said();
  ASSERT_LT(down_s, kNever_s) << all_said();
  EXPECT_EQ(range("z_m", 0.0, at("task_takeoff", "received")).second, 0.0)
      << "the aircraft left the ground before the order";
  const auto [low_m, high_m] = range("z_m", off_s + 2.0, off_s + 6.0);
  EXPECT_NEAR(low_m, 1.2, 0.25) << "the course must begin where the take-off ends";
  EXPECT_NEAR(high_m, 1.2, 0.25);
  EXPECT_LT(range("x_m", 0.0, down_s).second, 0.5);
  EXPECT_LT(range("y_m", 0.0, down_s).second, 0.5);
  EXPECT_EQ(range("z_m", down_s + 0.2, kNever_s).second, 0.0);
  EXPECT_LE(at("transmitter_has_control", "did", down_s) - down_s, 1.0) << "limit: the flight status at 10 Hz, and R15";
  EXPECT_EQ(times("task_takeoff"), 1) << "asked once";
  EXPECT_EQ(times("task_land"), 1);
  EXPECT_EQ(reported()["took_off"], true);
  EXPECT_EQ(reported()["landed"], true);
  EXPECT_NE(all_said().find("the aircraft is on the ground"), std::string::npos) << all_said();
  EXPECT_EQ(run({"replay", log.string()}), 0) << error();
}

// Catches a program that takes off because it has control, or because the aircraft is on the ground.
TEST_F(Tasks, NothingTakesOffWithoutTheWordForIt) {
  const auto autopilot = start_world({"--on-ground"});
  Process program(M100_PROGRAM, with({"fly", "--port", world, "--pose-port", world + ".pose", "--take-off"}, models()),
                  errors);
  EXPECT_TRUE(wait_for("\"truth\"", 100)) << "ten seconds";
  program.interrupt();
  EXPECT_EQ(program.wait(), 1) << error();
  (void)examined(*autopilot);
  EXPECT_EQ(times("obtain_control"), 0);
  EXPECT_EQ(times("task_takeoff"), 0);
  EXPECT_EQ(range("z_m", 0.0, kNever_s).second, 0.0);
}

TEST_F(Tasks, ThePilotsSwitchEndsATakeOffAtOnce) {
  RecordProperty("promise", "R4");
  (void)fly({"--take-off", "--hold", "6"});
  const double begun_s = at("task_takeoff", "received");
  ASSERT_LT(begun_s, kNever_s) << all_said();
  EXPECT_EQ(fly({"--take-off", "--hold", "6"}, std::to_string(begun_s + 0.7) + " mode P\n"), 1) << all_said();
  const double left_s = at("left_f");
  ASSERT_LT(left_s, kNever_s) << all_said();
  EXPECT_LT(range("z_m", 0.0, left_s).second, 1.2) << "the interrupt came after the take-off";
  EXPECT_LT(at("task_ended"), kNever_s);
  EXPECT_LE(at("transmitter_has_control", "did", left_s) - left_s, 0.1);
  EXPECT_EQ(times("task_takeoff"), 1) << "the request was repeated";
  Json last = every_event().back();
  EXPECT_LE(last["latest_after_loss_s"], 0.04);
  EXPECT_EQ(reported()["took_off"], false);
}

TEST_F(Tasks, ARefusedTakeOffIsSaidWithItsCodeAndControlGoesBack) {
  RecordProperty("promise", "R15");
  EXPECT_EQ(fly({"--take-off", "--hold", "6"}, "0 tasks off\n"), 1) << all_said();
  EXPECT_NE(all_said().find("take-off refused by the autopilot: refused, code 1"), std::string::npos) << all_said();
  EXPECT_EQ(times("task_takeoff"), 1);
  const double requested_s = at("task_takeoff", "received");
  EXPECT_LE(at("transmitter_has_control", "did", requested_s) - requested_s, 1.0);
  EXPECT_EQ(range("z_m", 0.0, kNever_s).second, 0.0);
}

TEST_F(Tasks, ARefusedLandingIsSaidAndThePilotHasTheSticksInTheAir) {
  RecordProperty("promise", "R15");
  EXPECT_EQ(fly({"--land", "--hold", "2"}, "0 tasks off\n", false), 1) << all_said();
  EXPECT_NE(all_said().find("landing refused by the autopilot: refused, code 1"), std::string::npos) << all_said();
  const double requested_s = at("task_land", "received");
  EXPECT_LE(at("transmitter_has_control", "did", requested_s) - requested_s, 1.0);
  EXPECT_GT(range("z_m", 0.0, kNever_s).first, 1.0);
}

TEST_F(Tasks, ATaskThatDoesNotBeginIsSaidAndControlGoesBack) {
  RecordProperty("promise", "R15");
  EXPECT_EQ(fly({"--take-off", "--hold", "6"}, "0 tasks stuck\n"), 1) << all_said();
  EXPECT_NE(all_said().find("take-off: the autopilot accepted it but did not begin"), std::string::npos) << all_said();
  const double requested_s = at("task_takeoff", "received");
  EXPECT_LE(at("transmitter_has_control", "did", requested_s) - requested_s, 5.0 + 1.0);
  EXPECT_EQ(times("task_takeoff"), 1);
}

// Without an answer and a flight status, the program waits one second, not the five seconds of an accepted task.
TEST_F(Tasks, ATaskThatNobodyAnswersIsSaidAndControlGoesBack) {
  RecordProperty("promise", "R15");
  const std::string script = "0 tasks stuck\n0 lose_acks 1000 task\n";
  EXPECT_EQ(fly({"--land", "--hold", "2"}, script, false), 1) << all_said();
  EXPECT_NE(all_said().find("landing: the autopilot does not answer, and its flight status does not show it"),
            std::string::npos)
      << all_said();
  const double requested_s = at("task_land", "received");
  EXPECT_LE(at("transmitter_has_control", "did", requested_s) - requested_s, 1.0 + 1.0);
  EXPECT_GT(range("z_m", 0.0, kNever_s).first, 1.0);
}

// In still air nothing drifts, so that only the time ends the task: 20 s for a take-off, 90 s for a landing.
TEST_F(Tasks, ATaskThatDoesNotEndIsSaidAndControlGoesBack) {
  RecordProperty("promise", "R15");
  const std::string still =
      "[air]\nattitude_disturbance_rad = 0\nclimb_disturbance_m_s = 0\nyaw_rate_disturbance_rad_s = 0\n"
      "linear_drag_per_s = 1\n";
  for (const bool lands : {false, true}) {
    const std::string task = lands ? "landing" : "take-off", request = lands ? "task_land" : "task_takeoff";
    const double longest_s = lands ? 90.0 : 20.0;
    EXPECT_EQ(fly({lands ? "--land" : "--take-off", "--hold", "2"}, "0 tasks endless\n", !lands, still), 1)
        << all_said();
    EXPECT_NE(all_said().find(task + ": the autopilot did not finish it in time"), std::string::npos) << all_said();
    const double requested_s = at(request, "received");
    const double handed_s = at("transmitter_has_control", "did", requested_s) - requested_s;
    EXPECT_GT(handed_s, longest_s);
    EXPECT_LE(handed_s, longest_s + 1.0);
    EXPECT_EQ(times(request), 1);
  }
}

// A landing that does not sink flies level, until the air has carried it a metre away.
TEST_F(Tasks, ALandingThatDriftsIsEndedAndThePilotHasTheSticksAtOnce) {
  RecordProperty("promise", "R15");
  EXPECT_EQ(fly({"--land", "--hold", "2"}, "0 tasks endless\n", false), 1) << all_said();
  EXPECT_NE(all_said().find("landing: it drifts with the wind and was ended"), std::string::npos) << all_said();
  const double requested_s = at("task_land", "received");
  const double handed_s = at("transmitter_has_control", "did", requested_s);
  EXPECT_LT(handed_s - requested_s, 90.0) << "limit: the longest landing from the height of a room";
  const auto moved_m = [&](const char* axis) {
    return range(axis, handed_s - 0.1, handed_s).second - range(axis, requested_s, requested_s + 0.1).first;
  };
  EXPECT_NEAR(std::hypot(moved_m("x_m"), moved_m("y_m")), 1.0, 0.2) << "a metre, and 0.3 s at 0.5 m/s";
}

TEST_F(Tasks, ALandingThatIsBrokenOffIsSaidAndControlGoesBack) {
  RecordProperty("promise", "R15");
  EXPECT_EQ(fly({"--land", "--hold", "2"}, "8 end_task\n", false), 1) << all_said();
  EXPECT_NE(all_said().find("landing: the autopilot aborted it"), std::string::npos) << all_said();
  EXPECT_LE(at("transmitter_has_control", "did", 8.0) - 8.0, 1.0 + 1.0 + 0.2) << "limit: seen for 1 s, then R15";
  EXPECT_GT(range("z_m", 0.0, kNever_s).first, 0.3) << "the aircraft did not hover meanwhile";
}

// The task needs no pose: a landing that stopped when the pose is lost would hand the aircraft to an unprepared pilot.
TEST_F(Tasks, ALandingGoesOnWithoutAPose) {
  RecordProperty("promise", "R15");
  (void)fly({"--land", "--hold", "2"}, "", false);
  const double begun_s = at("task_land", "received");
  ASSERT_LT(begun_s, kNever_s) << all_said();
  EXPECT_EQ(fly({"--land", "--hold", "2"}, std::to_string(begun_s + 0.5) + " pose off\n", false), 0) << all_said();
  const double down_s = at("landed");
  ASSERT_LT(down_s, kNever_s) << all_said();
  EXPECT_LE(at("transmitter_has_control", "did", down_s) - down_s, 1.0);
  EXPECT_EQ(reported()["landed"], true);
}

TEST_F(Tasks, ATakeOffWithoutAPoseBehindItGoesToThePilot) {
  RecordProperty("promise", "R15");
  (void)fly({"--take-off", "--hold", "6"});
  const double begun_s = at("task_takeoff", "received");
  EXPECT_EQ(fly({"--take-off", "--hold", "6"}, std::to_string(begun_s + 0.5) + " pose off\n"), 1) << all_said();
  const double off_s = at("taken_off");
  ASSERT_LT(off_s, kNever_s) << all_said();
  const double handed_s = at("transmitter_has_control", "did", off_s) - off_s;
  EXPECT_GT(handed_s, 1.0) << "level must wait for a pose";
  EXPECT_LE(handed_s, 3.5) << "limit: 0.5 s until the flight is noticed, 1 s level, neutral, release";
  EXPECT_NE(all_said().find("the transmitter has the aircraft"), std::string::npos) << all_said();
}

// Answers are lost on the line, but the autopilot's flight status shows the take-off, too. The request is repeated with
// the same number, so that the autopilot executes it once.
TEST_F(Tasks, ATakeOffWhoseAnswersAreLostIsFlownAllTheSame) {
  EXPECT_EQ(fly({"--take-off", "--land", "--hold", "2"}, "0 lose_acks 3 task\n"), 0) << all_said();
  EXPECT_EQ(times("task_takeoff"), 1);
  EXPECT_EQ(reported()["took_off"], true);
}

/// A wind of the flight file's class, which carries a level aircraft away.
class TasksInWind : public Tasks, public testing::WithParamInterface<double> {
 protected:
  int fly_in_wind(const std::string& script = "") {
    made("flight.toml",
         "[fence]\nx_m = [-3, 3]\ny_m = [-3, 3]\nz_m = [0.3, 4]\n[wind]\nclass_m_s = 5.0\n[battery]\nlow_percent = "
         "20\n");
    return fly({"--take-off", "--land", "--hold", "6"}, script, true,
               "[air]\nwind_m_s = [" + std::to_string(-GetParam()) + ", 0, 0]\nlinear_drag_per_s = 0.3\n");
  }
  /// True speed when the transmitter got control [m/s].
  double handed_over_m_s() const {
    const double then_s = at("transmitter_has_control", "did", at("taken_off"));
    const auto [low, high] = range("vx_m_s", then_s - 0.05, then_s + 0.05);
    return std::max(-low, high);
  }
};

// The autopilot's tasks hold the attitude, not the place. The take-off ends in the law's hands wherever it has drifted
// inside the fence; the landing would drift on, and is not ordered.
TEST_P(TasksInWind, TheLawTakesOverADriftedTakeOffAndHoversInsteadOfADriftingLanding) {
  EXPECT_EQ(fly_in_wind(), 1) << all_said();
  EXPECT_EQ(reported()["took_off"], true);
  EXPECT_EQ(reported()["landed"], false);
  EXPECT_EQ(times("task_land"), 0);
  EXPECT_NE(all_said().find("land by hand"), std::string::npos) << all_said();
  EXPECT_EQ(all_said().find("control is not taken"), std::string::npos) << all_said();
  const double handed_s = at("transmitter_has_control", "did", at("taken_off"));
  EXPECT_NEAR(handed_s - at("taken_off"), 17.0, 1.5) << "6 s of --hold, 10 s of hover";
  EXPECT_GT(range("x_m", 0.0, handed_s).first, -3.0);
  EXPECT_LT(handed_over_m_s(), 0.5);
  const auto [near_m, far_m] = range("x_m", handed_s - 5.0, handed_s);
  EXPECT_LT(far_m - near_m, 0.3) << "it hovers where the landing was ordered";
  EXPECT_EQ(run({"replay", log.string()}), 0) << error();
}

// A hover in place of a landing goes on for its ten seconds with a low battery, too: the pilot was told so.
TEST_P(TasksInWind, ALowBatteryDoesNotEndTheHoverBeforeThePilotLands) {
  EXPECT_EQ(fly_in_wind("16 lie battery 10\n"), 1) << all_said();
  EXPECT_NE(all_said().find("land by hand"), std::string::npos) << all_said();
  const double handed_s = at("transmitter_has_control", "did", at("taken_off"));
  EXPECT_NEAR(handed_s - at("taken_off"), 17.0, 1.5) << all_said();
  const auto [near_m, far_m] = range("x_m", handed_s - 5.0, handed_s);
  EXPECT_LT(far_m - near_m, 0.3);
}
INSTANTIATE_TEST_SUITE_P(Light, TasksInWind, testing::Values(2.0, 3.0));

class TasksInStrongWind : public TasksInWind {};

// At the end of the take-off nothing can stop the aircraft inside its fence: it brakes as soon as it may, and is handed
// over slowly.
TEST_P(TasksInStrongWind, ATakeOffThatTheWindCarriesAwayIsBrakedAndHandedOver) {
  EXPECT_EQ(fly_in_wind(), 1) << all_said();
  EXPECT_LT(handed_over_m_s(), 0.9) << all_said();
  EXPECT_EQ(all_said().find("control is not taken"), std::string::npos) << all_said();
  EXPECT_NE(all_said().find("the aircraft is outside its fence"), std::string::npos) << all_said();
}
INSTANTIATE_TEST_SUITE_P(OfTheClass, TasksInStrongWind, testing::Values(5.0));

TEST_F(Tasks, TheOperatorsWordLandsAFlightThatHasNoEnd) {
  const auto autopilot = start_world({"--on-ground"});
  FILE* const typed = popen(command({"--take-off", "--hold", "3600"}).c_str(), "w");
  ASSERT_NE(typed, nullptr);
  EXPECT_TRUE(wait_for("\"taken_off\""));
  std::fputs("land\n", typed);
  std::fflush(typed);
  EXPECT_TRUE(wait_for("\"landed\"")) << all_said();
  const int status = pclose(typed);
  EXPECT_EQ(WEXITSTATUS(status), 0) << all_said();
  (void)examined(*autopilot);
  EXPECT_EQ(times("task_land"), 1);
  EXPECT_LE(at("transmitter_has_control", "did", at("landed")) - at("landed"), 1.0);
  EXPECT_EQ(reported()["landed"], true);
}

}  // namespace
}  // namespace m100::scenario
