// SPDX-License-Identifier: BSD-3-Clause
// Logs as users bring them: clocks, lengths, names and forces that differ from what the map says.
#include <matio.h>
#include <cmath>
#include <map>
#include <random>

#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/logs/proposal/propose.h"
#include "host_tests/unit/logs/log_files.h"
#include "host_tests/unit/logs/log_samples.h"

namespace m100::lab::logs {
namespace {

RawColumn values_of(std::vector<double> values, std::vector<double> time_s = {}, std::vector<double> sequence = {}) {
  return {.values = std::move(values), .time_s = std::move(time_s), .sequence = std::move(sequence)};
}

template <typename F>
std::vector<double> series(std::size_t count, F&& at) {
  std::vector<double> out(count);
  for (std::size_t k = 0; k < count; ++k) {
    out[k] = at(static_cast<double>(k));
  }
  return out;
}

ColumnMap map_with(const std::string& signals) {
  return parse_column_map("time = \"t\"\n[signals]\n" + signals, "map");
}

bool notes_have(const FlightLog& log, const std::string& words) {
  return std::any_of(log.notes.begin(), log.notes.end(),
                     [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

constexpr std::size_t kRows = 2000;
double sine(double t) { return std::sin(5.0 * t); }
double bunched(double k) { return 0.05 * std::floor(k / 5.0) + 0.04 + 1e-4 * std::fmod(k, 5.0); }

double worst_error(const FlightLog& log) {
  double worst = 0.0;
  for (std::size_t k = 5; k + 5 < log.size; ++k) {
    worst = std::max(worst, std::abs(log.of(Signal::kRateX)[k] - sine(log.time_s(k))));
  }
  return worst;
}

// Catches arrivals taken as times: samples up to 40 ms late make an error of 0.2, and holes of 50 ms are gaps.
TEST(UnseenLog, BunchedRowsAreSpreadAndANoteSaysSo) {
  const MemoryLog raw({{"t", values_of(series(kRows, bunched))},
                       {"x", values_of(series(kRows, [](double k) { return sine(0.01 * k); }))}});
  const FlightLog log = load(raw, map_with("rate_x = \"x\""));
  EXPECT_LT(worst_error(log), 0.02);
  EXPECT_EQ(std::count(log.gap.begin(), log.gap.end(), 1), 0);
  EXPECT_TRUE(notes_have(log, "regular rate")) << log.notes.size();
}

TEST(UnseenLog, ASequenceOfTheMapIsObeyed) {
  std::vector<double> t;
  std::vector<double> x;
  std::vector<double> number;
  for (std::size_t k = 0; k < kRows; ++k) {
    if (k % 7 != 3) {  // lost
      t.push_back(bunched(static_cast<double>(k)));
      x.push_back(sine(0.01 * static_cast<double>(k)));
      number.push_back(static_cast<double>(k));
    }
  }
  const MemoryLog raw({{"t", values_of(t)}, {"x", values_of(x)}, {"n", values_of(number)}});
  const FlightLog log = load(raw, map_with("rate_x = \"x\"\nsequence = \"n\""));
  EXPECT_LT(worst_error(log), 0.02);
  EXPECT_TRUE(notes_have(log, "by their counter"));
}

TEST(UnseenLog, RepeatedRowsOfASlowMessageAreNoBunch) {
  const MemoryLog raw({{"t", values_of(series(kRows, [](double k) { return 0.05 * std::floor(k / 5.0); }))},
                       {"x", values_of(series(kRows, [](double k) { return sine(0.05 * std::floor(k / 5.0)); }))}});
  const FlightLog log = load(raw, map_with("rate_x = \"x\""));
  EXPECT_LT(worst_error(log), 0.02);
  EXPECT_TRUE(notes_have(log, "repeated time stamps"));
}

TEST(UnseenLog, AStreamThatDoesNotOverlapWithTheClockIsAnError) {
  const MemoryLog raw({{"t", values_of(series(kRows, [](double k) { return 1.7e9 + 0.01 * k; }))},
                       {"x", values_of(series(kRows, sine), series(kRows, [](double k) { return 0.01 * k; }))}});
  const std::string said = complaint_of([&] { load(raw, map_with("rate_x = \"x\"")); });
  EXPECT_NE(said.find("'x'"), std::string::npos) << said;
  EXPECT_NE(said.find("overlap"), std::string::npos) << said;
}

TEST(UnseenLog, TheLastOfOneStateMoreThanStepsIsLeftOut) {
  const MemoryLog raw({{"t", values_of(series(kRows, [](double k) { return 0.01 * k; }))},
                       {"x", values_of(series(kRows + 1, [](double k) { return sine(0.01 * k); }))},
                       {"y", values_of(series(kRows + 2, sine))}});
  const FlightLog log = load(raw, map_with("rate_x = \"x\""));
  EXPECT_LT(worst_error(log), 1e-9);
  EXPECT_TRUE(notes_have(log, "N + 1 states"));
  EXPECT_NE(complaint_of([&] { load(raw, map_with("rate_x = \"y\"")); }).find("its clock 2000"), std::string::npos);
}

/// A flight that tilts by a tenth; the force in body axes, in world axes, or without gravity.
FlightLog flight(bool in_world, bool has_gravity) {
  constexpr double kGravity = 9.81;
  const auto roll = [](double k) { return 0.1 * std::sin(0.02 * k); };
  const auto pitch = [](double k) { return 0.1 * std::cos(0.013 * k); };
  std::map<std::string, RawColumn> columns{{"t", values_of(series(kRows, [](double k) { return 0.01 * k; }))},
                                           {"r", values_of(series(kRows, roll))},
                                           {"p", values_of(series(kRows, pitch))},
                                           {"y", values_of(series(kRows, [](double) { return 0.4; }))}};
  std::array<std::vector<double>, 3> force;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.2);
  for (std::size_t k = 0; k < kRows; ++k) {
    const double r = roll(static_cast<double>(k));
    const double p = pitch(static_cast<double>(k));
    const double forward = kGravity * std::sin(p) * std::cos(r);
    const double left = -kGravity * std::sin(r);
    const std::array<double, 3> world{forward * std::cos(0.4) - left * std::sin(0.4),
                                      forward * std::sin(0.4) + left * std::cos(0.4), kGravity};
    for (std::size_t i = 0; i < 3; ++i) {
      const double thrust = i == 2 ? kGravity : 0.0;
      force[i].push_back((in_world ? world[i] : thrust) - (has_gravity ? 0.0 : thrust) + noise(random));
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    columns["f" + std::to_string(i)] = values_of(force[i]);
  }
  return load(MemoryLog(columns), map_with("attitude_roll = \"r\"\nattitude_pitch = \"p\"\nattitude_yaw = \"y\"\n"
                                           "force_x = \"f0\"\nforce_y = \"f1\"\nforce_z = \"f2\""));
}

TEST(UnseenLog, OnlyASpecificForceInBodyAxesIsUsed) {
  EXPECT_TRUE(flight(false, true).has3(Signal::kForceX));
  const FlightLog world = flight(true, true);
  EXPECT_FALSE(world.has(Signal::kForceX));
  EXPECT_TRUE(notes_have(world, "world axes"));
  const FlightLog free = flight(true, false);
  EXPECT_FALSE(free.has(Signal::kForceX));
  EXPECT_TRUE(notes_have(free, "gravity was subtracted"));
  EXPECT_FALSE(flight(false, false).has(Signal::kForceZ));
}

// --- names and formats ---

TEST(UnseenLog, AColumnWithoutANameIsNumbered) {
  const std::string file = host_tests::made("a.csv", ",t,x,\n0,0.0,1,5\n1,0.1,2,6\n");
  const auto log = open_log(file);
  EXPECT_EQ(log->names(), (std::vector<std::string>{"column_1", "t", "x", "column_4"}));
  EXPECT_EQ(log->column("column_4", "x").values, (std::vector<double>{5.0, 6.0}));
  EXPECT_FALSE(propose(*log));
}

TEST(UnseenLog, ArduPilotsMillisecondsAreTheClockAndTheGpsWeekIsNot) {
  std::string bytes = definition('\x80', 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns") +
                      definition(1, 15, "ATT", "Icccc", "TimeMS,DesRoll,Roll,DesPitch,Pitch") +
                      definition(2, 9, "GPS", "IH", "TimeMS,Week") + definition(3, 13, "GPS2", "IHI", "TimeMS,Week,T");
  for (std::uint32_t k = 0; k < 40; ++k) {
    const std::uint32_t week_ms = 400'000'000U + 20U * k;
    bytes += record(1, UlogBytes::raw(1000U + 20U * k) + std::string(8, '\1'));
    bytes += record(2, UlogBytes::raw(week_ms) + "\1\1");
    bytes += record(3, UlogBytes::raw(week_ms) + "\1\1" + UlogBytes::raw(1000U + 20U * k));
  }
  const std::string file = host_tests::made("a.bin", bytes);
  const auto log = open_log(file);
  for (const TopicSummary& topic : log->topics()) {
    EXPECT_LT(topic.to_s, 2.0) << topic.name;
    EXPECT_EQ(topic.messages, 40U) << topic.name;
  }
  EXPECT_NEAR(log->column("GPS2.Week", "x").time_s[1], 1.02, 1e-9);
  const auto proposal = propose(*log);
  ASSERT_TRUE(proposal);
  EXPECT_NE(proposal->toml.find("time = \"ATT.TimeMS\""), std::string::npos) << proposal->toml;
}

TEST(UnseenLog, TheSetPointIsProposedWhereTheSticksRest) {
  std::map<std::string, RawColumn> columns;
  const std::vector<double> t = series(kRows, [](double k) { return 0.01 * k; });
  columns["/dji_sdk/attitude.time"] = values_of(t, t);
  for (const char* const part : {"w", "x", "y", "z"}) {
    columns["/dji_sdk/attitude.quaternion." + std::string(part)] = values_of(std::vector<double>(kRows, 0.5), t);
  }
  for (int i = 0; i < 5; ++i) {
    columns["/dji_sdk/rc.axes[" + std::to_string(i) + "]"] = values_of(std::vector<double>(kRows, 0.0), t);
    columns["/dji_sdk/flight_control_setpoint_generic.axes[" + std::to_string(i) + "]"] =
        values_of(std::vector<double>(kRows, i == 4 ? 0x0A : 0.1), t);
  }
  const std::string resting = propose(MemoryLog(columns))->toml;
  EXPECT_NE(resting.find("command_roll = \"/dji_sdk/flight_control_setpoint_generic.axes[0]\""), std::string::npos);
  EXPECT_NE(resting.find("command_yaw_rate"), std::string::npos);
  EXPECT_EQ(resting.find("\nstick_roll"), std::string::npos) << resting;
  parse_column_map(resting, "proposed");
  columns["/dji_sdk/rc.axes[1]"] = values_of(series(kRows, sine), t);
  const std::string moving = propose(MemoryLog(columns))->toml;
  EXPECT_EQ(moving.find("\ncommand_roll"), std::string::npos) << moving;
  EXPECT_NE(moving.find("\nstick_roll"), std::string::npos);
}

void write_mat(const std::string& path, mat_ft version, const char* name, const std::vector<double>& values) {
  mat_t* const mat = Mat_CreateVer(path.c_str(), nullptr, version);
  std::array<std::size_t, 2> size{2, values.size() / 2};
  std::array<std::size_t, 2> one{1, 1};
  std::array<const char*, 1> field{"x"};
  std::vector<double> copy = values;
  matvar_t* const outer = Mat_VarCreateStruct(name, 2, one.data(), field.data(), 1);
  Mat_VarSetStructFieldByName(outer, "x", 0,
                              Mat_VarCreate("x", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), copy.data(), 0));
  Mat_VarWrite(mat, outer, MAT_COMPRESSION_NONE);
  Mat_VarFree(outer);
  Mat_Close(mat);
}

TEST(UnseenLog, Matlab73IsReadAndACutOneIsNamed) {
  const std::string file = host_tests::made("a.mat", "");
  std::filesystem::remove(file);
  write_mat(file, MAT_FT_MAT73, "E", series(60, [](double k) { return k; }));
  const auto log = open_log(file);
  EXPECT_EQ(log->format(), "MAT 7.3");
  EXPECT_EQ(log->names(), (std::vector<std::string>{"E.x[1]", "E.x[2]"}));
  EXPECT_DOUBLE_EQ(log->column("E.x[2]", "x").values[3], 7.0);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 100);
  EXPECT_NE(complaint_of([&] { open_log(file); }).find("7.3"), std::string::npos);
}

TEST(UnseenLog, AFlightMayLieInSeveralMatFilesOfOneFolder) {
  const std::string clock = host_tests::made("clock.mat", "");
  const std::string states = host_tests::made("states.mat", "");
  write_mat(clock, MAT_FT_MAT5, "c", series(60, [](double k) { return 0.01 * k; }));
  write_mat(states, MAT_FT_MAT5, "s", series(60, [](double k) { return k; }));
  const std::string name = std::filesystem::path(states).filename().string();
  const auto log = open_log(clock);
  EXPECT_DOUBLE_EQ(log->column(name + ":s.x[1]", "x").values[2], 4.0);
  for (const char* const wrong : {"none.mat:s.x[1]", "c.y", "c.x", "c.x[3]", "c.x[0]"}) {
    const std::string map = "time = \"c.x[1]\"\n[signals]\nrate_x = \"" + std::string(wrong) + "\"";
    EXPECT_EQ(complaint_of([&] { load(*log, parse_column_map(map, "map")); }).rfind("map:3: 'rate_x': ", 0), 0U);
  }
}

}  // namespace
}  // namespace m100::lab::logs
