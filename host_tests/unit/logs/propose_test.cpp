// SPDX-License-Identifier: BSD-3-Clause
// Column maps that are proposed for recognised logs: they must load, and say what is known of the flights.
#include "host_tests/lab/logs/proposal/propose.h"

#include <cmath>

#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/logs/proposal/example_map.h"
#include "host_tests/shared_files.h"
#include "host_tests/unit/logs/log_files.h"

namespace m100::lab::logs {
namespace {

struct Known {
  const char* name;
  const char* file;
  const char* dialect;
  std::vector<Signal> has;
};
class KnownLog : public ::testing::TestWithParam<Known> {};

TEST_P(KnownLog, IsRecognisedAndItsMapLoads) {
  M100_SHARED_FILE_OR_SKIP(path, std::string("data/") + GetParam().file);
  const auto raw = open_log(path.string());
  const auto proposal = propose(*raw);
  ASSERT_TRUE(proposal);
  EXPECT_EQ(proposal->dialect, GetParam().dialect);
  const FlightLog log = load(*raw, parse_column_map(proposal->toml, "proposed"));
  for (const Signal signal : GetParam().has) {
    EXPECT_TRUE(log.has(signal)) << name_of(signal) << "\n" << proposal->toml;
  }
  EXPECT_FALSE(raw->topics().empty());
}

INSTANTIATE_TEST_SUITE_P(
    Shared, KnownLog,
    ::testing::Values(Known{"Px4Of2017",
                            "px4/sample.ulg",
                            "PX4",
                            {Signal::kAttitudeRoll, Signal::kCommandRoll, Signal::kRateX, Signal::kForceZ,
                             Signal::kVelocityX}},
                      Known{"Px4Small", "px4/sample_log_small.ulg", "PX4", {Signal::kAttitudeRoll, Signal::kRateX}},
                      Known{"Px4Appended", "px4/sample_appended_multiple.ulg", "PX4", {Signal::kAttitudeRoll}},
                      Known{"ArduPilot",
                            "formats/tiny.bin",
                            "ArduPilot",
                            {Signal::kAttitudeRoll, Signal::kCommandRoll, Signal::kVelocityX, Signal::kPositionZ}},
                      Known{"DjiBag", "formats/bag_humble.db3", "a DJI bag", {Signal::kAttitudeRoll, Signal::kRateX}},
                      Known{"PublishedMat",
                            "m100/ExperimentPitchRoll.mat",
                            "the published MAT-files",
                            {Signal::kAttitudeRoll, Signal::kStickRoll, Signal::kRateX}},
                      Known{"MeasuredCsv",
                            "m100/pitch_roll.csv",
                            "the measured flights as CSV",
                            {Signal::kAttitudeRoll, Signal::kStickRoll, Signal::kRateX}},
                      Known{"BlindExample",
                            "blind_examples/log_00.csv",
                            "the measured flights as CSV",
                            {Signal::kAttitudeRoll, Signal::kStickRoll, Signal::kPositionX, Signal::kForceZ}}),
    [](const auto& tested) { return tested.param.name; });

/// A bag of 20 s that a program flies by the generic set point (climb and turn rate) for `program_s`, and a pilot
/// before.
MemoryLog dji_bag(double nudge, std::size_t nudged_rows, double program_s, double size = 0.5) {
  std::map<std::string, RawColumn> columns;
  std::vector<double> t(1000);
  for (std::size_t k = 0; k < t.size(); ++k) {
    t[k] = 0.02 * static_cast<double>(k);
  }
  const auto add = [&](const std::string& name, auto&& value) {
    RawColumn& column = columns[name];
    column.time_s = t;
    for (std::size_t k = 0; k < t.size(); ++k) {
      column.values.push_back(value(k));
    }
  };
  const auto flies = [&](std::size_t k) { return t[k] >= 20.0 - program_s; };
  for (const char* const part : {"w", "x", "y", "z"}) {
    add(std::string("/dji_sdk/attitude.quaternion.") + part, [&](std::size_t) { return *part == 'w' ? 1.0 : 0.0; });
  }
  add("/dji_sdk/attitude.time", [&](std::size_t k) { return t[k]; });
  for (int axis = 0; axis < 5; ++axis) {
    const std::string end = ".axes[" + std::to_string(axis) + "]";
    add("/dji_sdk/flight_control_setpoint_generic" + end, [&](std::size_t k) {
      return axis == 4 ? 75.0 : axis > 1 && flies(k) ? size * std::sin(t[k] + axis) : 0.0;
    });
    add("/dji_sdk/rc" + end, [&](std::size_t k) {
      const bool is_nudged = axis == 3 && k >= 700 && k < 700 + nudged_rows;
      return is_nudged ? nudge / 660.0 : axis < 4 && !flies(k) ? 0.3 * std::sin(2.0 * t[k] + axis) : 0.0;
    });
  }
  return MemoryLog(std::move(columns));
}

// Catches one sample of a touched stick that makes the pilot's sticks the command of a flight that a program flew.
TEST(Propose, MapsTheCommandThatMovesTheAircraftMostOfTheTime) {
  struct Flown {
    double nudge;
    std::size_t rows;
    double program_s;
    bool by_setpoint;
  };
  for (const Flown& flown : {Flown{0.0, 0, 20.0, true}, Flown{39.0, 1, 20.0, true}, Flown{8.0, 50, 20.0, true},
                             Flown{510.0, 100, 20.0, true}, Flown{0.0, 0, 13.0, true}, Flown{0.0, 0, 6.0, false},
                             Flown{0.0, 0, 0.0, false}}) {
    const auto proposal = propose(dji_bag(flown.nudge, flown.rows, flown.program_s));
    ASSERT_TRUE(proposal);
    const ColumnMap map = parse_column_map(proposal->toml, "proposed");
    const auto has = [&](Signal signal) { return map.signals[static_cast<std::size_t>(signal)].has_value(); };
    EXPECT_EQ(has(Signal::kCommandClimb), flown.by_setpoint) << flown.nudge << " " << flown.program_s;
    EXPECT_EQ(has(Signal::kStickThrottle), !flown.by_setpoint) << flown.nudge << " " << flown.program_s;
    EXPECT_NE(proposal->toml.find(flown.by_setpoint ? "# stick_throttle = " : "# command_climb = "), std::string::npos)
        << "the other candidate is named";
  }
}

// A set point that holds still flies the aircraft, too: a touch of the sticks is no flight.
TEST(Propose, TakesATouchForNoFlight) {
  MemoryLog bag = dji_bag(39.0, 20, 20.0, 0.0);
  EXPECT_EQ(propose(bag)->toml.find("\nstick_roll"), std::string::npos) << propose(bag)->toml;
}

TEST(ExampleMap, TakesColumnsByTheirOwnNames) {
  struct Named {
    const char* column;
    std::optional<Signal> signal;
  };
  for (const Named& named :
       {Named{"roll", Signal::kAttitudeRoll}, Named{"cmd_roll", Signal::kCommandRoll},
        Named{"pitch_rate", Signal::kRateY}, Named{"rollRate", Signal::kRateX},
        Named{"des_yaw_rate", Signal::kCommandYawRate}, Named{"vx", Signal::kVelocityX},
        Named{"odom_roll_rad", Signal::kAttitudeRoll}, Named{"rc_throttle", Signal::kStickThrottle},
        Named{"position.z", Signal::kPositionZ}, Named{"gyro[x]", Signal::kRateX}, Named{"acc_z", Signal::kForceZ},
        Named{"cmd_thrust", std::nullopt}, Named{"roll_error", std::nullopt}, Named{"cmd_rc_roll", std::nullopt},
        Named{"roll_pitch", std::nullopt}, Named{"battery", std::nullopt}, Named{"", std::nullopt}}) {
    std::size_t unknown = 0;
    EXPECT_EQ(signal_named(named.column, unknown), named.signal) << named.column;
  }
  std::string text = "cmd_thrust,cmd_roll,rc_yaw,pitch_rate,roll,battery,time\n";
  for (int k = 0; k < 100; ++k) {
    text += "0.5,0.1,1500,0," + std::to_string(k - 50) + ",12," + std::to_string(0.01 * k) + "\n";
  }
  const std::string file = host_tests::made("a.csv", text);
  const std::string example = example_map(*open_log(file));
  const ColumnMap map = parse_column_map(example, "example");
  EXPECT_EQ(map.time.column, "time");
  EXPECT_EQ(map.signals[static_cast<std::size_t>(Signal::kAttitudeRoll)]->column, "roll");
  EXPECT_NEAR(map.signals[static_cast<std::size_t>(Signal::kAttitudeRoll)]->scale, 0.017453, 1e-6) << "beyond a turn";
  EXPECT_EQ(map.signals[static_cast<std::size_t>(Signal::kCommandRoll)]->column, "cmd_roll");
  EXPECT_EQ(map.signals[static_cast<std::size_t>(Signal::kRateY)]->column, "pitch_rate");
  EXPECT_EQ(map.signals[static_cast<std::size_t>(Signal::kStickYaw)]->offset, -1500.0);
  EXPECT_EQ(example.find("battery"), std::string::npos);
}

TEST(ExampleMap, LeavesOpenWhatNoNameStates) {
  const std::string file = host_tests::made("a.csv", "a,b,c\n0,1,7\n0.01,2,7\n0.02,2,7\n");
  const std::string example = example_map(*open_log(file));
  EXPECT_NE(example.find("time = { column = \"a\""), std::string::npos) << example;
  EXPECT_NE(example.find("attitude_roll = { column = \"...\""), std::string::npos) << example;
}

TEST(Propose, SaysNothingOfNamesThatItDoesNotKnow) {
  const std::string file = host_tests::made("a.csv", "a,b\n0,1\n1,2\n");
  EXPECT_FALSE(propose(*open_log(file)));
}

}  // namespace
}  // namespace m100::lab::logs
