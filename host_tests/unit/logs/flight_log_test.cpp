// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/flight_log.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "host_tests/lab/logs/join.h"
#include "host_tests/lab/logs/write_csv.h"
#include "host_tests/shared_files.h"
#include "host_tests/unit/logs/log_files.h"

namespace m100::lab::logs {
namespace {

ColumnMap map_of(const std::string& signals) { return parse_column_map("time = \"t\"\n[signals]\n" + signals, "map"); }

double wave(double t) { return std::sin(3.0 * t) + 0.5 * std::cos(1.3 * t); }

std::vector<double> clock_of(std::size_t count, double period_s) {
  std::vector<double> t(count);
  for (std::size_t k = 0; k < count; ++k) {
    t[k] = 5.0 + static_cast<double>(k) * period_s;
  }
  return t;
}

template <typename F>
std::vector<double> mapped(const std::vector<double>& t, F f) {
  std::vector<double> out;
  out.reserve(t.size());
  for (const double x : t) {
    out.push_back(f(x));
  }
  return out;
}

TEST(FlightLog, PutsAnIrregularClockOnAUniformGrid) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> jitter(-0.004, 0.004);
  auto t = clock_of(500, 0.01);
  for (double& x : t) {
    x += jitter(random);
  }
  const MemoryLog raw({{"t", {.values = t, .time_s = {}, .sequence = {}}},
                       {"x", {.values = mapped(t, wave), .time_s = {}, .sequence = {}}}});
  const FlightLog log = load(raw, map_of("rate_x = { column = \"x\", scale = 2, offset = 1 }"));
  for (std::size_t k = 0; k < log.size; ++k) {
    EXPECT_NEAR(log.of(Signal::kRateX)[k], 2 * (wave(log.time_s(k)) + 1), 1e-3);
    EXPECT_EQ(log.gap[k], 0);
  }
  EXPECT_EQ(log.index_of(log.start_s), 0U);
  EXPECT_EQ(log.index_of(log.start_s + 1.0), 100U);
  EXPECT_EQ(log.index_of(1e9), log.size);
}

// Catches a stick in fast rows that is read at the samples only: a jump between two samples would be up to one late.
TEST(FlightLog, AveragesAStickInFastRowsOverTheSampleThatHoldsIt) {
  const auto t = clock_of(400, 0.0025);
  const MemoryLog raw(
      {{"t", {.values = t, .time_s = {}, .sequence = {}}},
       {"x", {.values = mapped(t, [](double s) { return s < 5.5024 ? 0.0 : 80.0; }), .time_s = {}, .sequence = {}}}});
  const FlightLog log = load(raw, map_of("stick_roll = \"x\""));
  EXPECT_NEAR(log.of(Signal::kStickRoll)[49], 0.0, 1e-9);
  EXPECT_NEAR(log.of(Signal::kStickRoll)[50], 70.0, 1e-9);
  EXPECT_NEAR(log.of(Signal::kStickRoll)[51], 80.0, 1e-9);
}

TEST(FlightLog, MarksDropoutsAndKeepsTheFirstOfRepeatedStamps) {
  auto t = clock_of(300, 0.01);
  t.erase(t.begin() + 100, t.begin() + 140);
  auto x = mapped(t, wave);
  t.insert(t.begin() + 11, t[10]);
  x.insert(x.begin() + 11, 1e6);
  const MemoryLog raw(
      {{"t", {.values = t, .time_s = {}, .sequence = {}}}, {"x", {.values = x, .time_s = {}, .sequence = {}}}});
  const FlightLog log = load(raw, map_of("rate_x = \"x\""));
  EXPECT_NEAR(log.of(Signal::kRateX)[10], wave(5.1), 1e-9);
  EXPECT_EQ(log.gap[98], 0);
  EXPECT_EQ(log.gap[101], 1);
  EXPECT_EQ(log.gap[138], 1);
  EXPECT_EQ(log.gap[141], 0);
  EXPECT_EQ(log.notes.size(), 1U);
  EXPECT_EQ(log.gap_notes.size(), 1U);
}

TEST(FlightLog, RefusesAClockThatRunsBackwards) {
  auto t = clock_of(100, 0.1);
  for (std::size_t k = 50; k < t.size(); ++k) {
    t[k] = t[k - 1] - 0.1;
  }
  const MemoryLog raw(
      {{"t", {.values = t, .time_s = {}, .sequence = {}}}, {"x", {.values = t, .time_s = {}, .sequence = {}}}});
  EXPECT_EQ(complaint_of([&] { load(raw, map_of("rate_x = \"x\"")); }), "made:51: 't': time runs backwards");
}

// A log is a list of stretches: a pause, a second flight and a clock that is set begin a new one, at any rate, and each
// keeps its own times. Catches a rate, a unit or a grid that is taken from the pause.
class Stretches : public ::testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(Stretches, KeepTheirTimesAndTheirRate) {
  const auto [jump_s, period_s] = GetParam();
  auto t = clock_of(300, period_s);
  const auto x = mapped(t, wave);
  for (std::size_t k = 200; k < t.size(); ++k) {
    t[k] += jump_s;
  }
  const TopicSummary summary = summary_of("", "", t, {});
  EXPECT_NEAR(summary.rate_hz, 1.0 / period_s, 1e-6 / period_s);
  EXPECT_EQ(summary.from_s, t.front());
  EXPECT_EQ(summary.to_s, t.back());
  const MemoryLog raw({{"t", {.values = t, .time_s = {}, .sequence = {}}},
                       {"x", {.values = x, .time_s = {}, .sequence = {}}},
                       {"y", {.values = x, .time_s = t, .sequence = {}}}});
  const FlightLog log = load(raw, map_of("rate_x = \"x\"\nrate_y = \"y\""), period_s);
  ASSERT_EQ(log.flights.size(), 2U);
  EXPECT_LT(log.size, 300U + static_cast<std::size_t>(5.0 / period_s) + 3U) << "a pause costs no memory";
  for (std::size_t i = 0; i < 2; ++i) {
    const Flight& part = log.flights[i];
    EXPECT_EQ(part.start_s, t[i * 200]);
    ASSERT_EQ(part.end - part.begin, i == 0 ? 200U : 100U);
    for (std::size_t k = part.begin; k < part.end; ++k) {
      EXPECT_NEAR(log.of(Signal::kRateX)[k], x[i * 200 + k - part.begin], 1e-6 + 1e-7 * std::abs(jump_s));
      EXPECT_NEAR(log.of(Signal::kRateY)[k], x[i * 200 + k - part.begin], 1e-6 + 1e-7 * std::abs(jump_s));
      EXPECT_EQ(log.gap[k], 0) << k;
    }
  }
  const auto gap = log.gap_of({Signal::kRateY});
  EXPECT_EQ(std::count(gap.begin() + 200, gap.end(), 1), static_cast<long>(log.flights[1].begin) - 200);
  EXPECT_EQ(log.of(Signal::kRateX)[log.flights[1].begin - 1], log.of(Signal::kRateX)[log.flights[1].begin]);
  EXPECT_EQ(place_of(log, joined_time(log, 1, t[200] + period_s)).substr(0, 2), "2@");
  const std::string csv = host_tests::made("out.csv", "");
  write_csv(log, csv);
  const FlightLog again =
      load(*open_log(csv), parse_column_map("time = \"t_s\"\n[signals]\nrate_x = \"rate_x\"", ""), period_s);
  ASSERT_EQ(again.flights.size(), 2U) << "convert writes the times of the file, and no rows for a pause";
  EXPECT_NEAR(again.flights[1].start_s, t[200], 1e-6);
  EXPECT_EQ(again.size, log.size);
}

INSTANTIATE_TEST_SUITE_P(Breaks, Stretches,
                         ::testing::Combine(::testing::Values(628.0, 12.0, -0.3, -300.0, 1.7e9),
                                            ::testing::Values(0.01, 0.1)));

TEST(FlightLog, RefusesAStreamWhoseClockIsSetBackElsewhere) {
  const auto t = clock_of(300, 0.01);
  auto own = t;
  std::for_each(own.begin() + 100, own.end(), [](double& s) { s -= 0.5; });
  const MemoryLog raw(
      {{"t", {.values = t, .time_s = {}, .sequence = {}}}, {"x", {.values = t, .time_s = own, .sequence = {}}}});
  EXPECT_EQ(complaint_of([&] { load(raw, map_of("rate_x = \"x\"")); }).rfind("made:101: 'x': time runs backwards", 0),
            0U);
}

TEST(FlightLog, RefusesColumnsWhoseLengthsDoNotAgree) {
  const MemoryLog raw({{"t", {.values = clock_of(100, 0.01), .time_s = {}, .sequence = {}}},
                       {"x", {.values = clock_of(99, 0.01), .time_s = {}, .sequence = {}}}});
  EXPECT_EQ(
      complaint_of([&] { load(raw, map_of("rate_x = \"x\"")); }).rfind("made: 'x': has 99 samples, its clock 100", 0),
      0U);
}

TEST(FlightLog, RefusesATimeInMicroseconds) {
  const MemoryLog raw(
      {{"t", {.values = mapped(clock_of(100, 0.01), [](double x) { return 1e12 * x; }), .time_s = {}, .sequence = {}}},
       {"x", {.values = clock_of(100, 0.01), .time_s = {}, .sequence = {}}}});
  EXPECT_EQ(complaint_of([&] { load(raw, map_of("rate_x = \"x\"")); }).rfind("made: 't': spans more than 10 days", 0),
            0U);
}

// In the published MAT-files the clock of each stream begins with its own first message.
TEST(FlightLog, MovesSticksToMatchTheMessageCounters) {
  const auto t = clock_of(400, 0.01);
  std::vector<double> counter(400);
  std::vector<double> stick(400);
  std::vector<double> stick_counter(400);
  for (std::size_t k = 0; k < 400; ++k) {
    counter[k] = std::fmod(65500.0 + static_cast<double>(k), 65536.0);
    stick_counter[k] = std::fmod(65502.0 + static_cast<double>(k), 65536.0);
    stick[k] = wave(t[k] + 0.02);  // row k was sent two messages after the attitude of row k
  }
  const MemoryLog raw({{"t", {.values = t, .time_s = {}, .sequence = counter}},
                       {"x", {.values = stick, .time_s = {}, .sequence = stick_counter}}});
  const FlightLog log = load(raw, map_of("stick_roll = \"x\""));
  EXPECT_EQ(log.alignment.stick_shift_samples, 2);
  EXPECT_EQ(log.alignment.evidence, "sequence");
  for (std::size_t k = 2; k < log.size; ++k) {
    EXPECT_NEAR(log.of(Signal::kStickRoll)[k], wave(log.time_s(k)), 1e-9);
  }
}

// A turn with a pitch angle turns the body about x, too. Without it in the comparison these rates seemed 0.14 s late.
TEST(FlightLog, LeavesTheRatesOfATurnWhereTheyAre) {
  const auto t = clock_of(2000, 0.01);
  constexpr double kPitch_rad = 0.3;
  const auto rolling = [](double at) { return 0.4 * std::cos(2.0 * at); };
  const auto turning = [](double at) { return 0.4 * std::sin(2.0 * at); };
  const MemoryLog raw(
      {{"t", {.values = t, .time_s = {}, .sequence = {}}},
       {"roll",
        {.values = mapped(t, [](double at) { return 0.2 * std::sin(2.0 * at); }), .time_s = {}, .sequence = {}}},
       {"pitch", {.values = mapped(t, [](double) { return kPitch_rad; }), .time_s = {}, .sequence = {}}},
       {"yaw",
        {.values = mapped(t, [](double at) { return -0.2 * std::cos(2.0 * at); }), .time_s = {}, .sequence = {}}},
       {"p",
        {.values = mapped(t, [&](double at) { return rolling(at) - std::sin(kPitch_rad) * turning(at); }),
         .time_s = {},
         .sequence = {}}}});
  const FlightLog log =
      load(raw, map_of("attitude_roll = \"roll\"\nattitude_pitch = \"pitch\"\nattitude_yaw = \"yaw\"\nrate_x = \"p\""),
           0.01);
  EXPECT_EQ(log.alignment.rate_shift_samples, 0);
  EXPECT_EQ(log.alignment.evidence, "correlation");
}

TEST(FlightLog, FindsByCorrelationRatesThatLieBesideTheAttitude) {
  const auto t = clock_of(2000, 0.01);
  const auto rate = [](double at) { return 3.0 * std::cos(3.0 * (at + 0.2)) - 0.65 * std::sin(1.3 * (at + 0.2)); };
  std::vector<double> rates = mapped(t, rate);
  std::fill_n(&rates[500], 20, std::nan(""));
  const MemoryLog raw({{"t", {.values = t, .time_s = {}, .sequence = {}}},
                       {"x", {.values = mapped(t, wave), .time_s = {}, .sequence = {}}},
                       {"p", {.values = rates, .time_s = {}, .sequence = {}}}});
  for (const int per_row : {1, 4}) {
    const FlightLog log = load(raw, map_of("attitude_roll = \"x\"\nrate_x = \"p\""), 0.01 / per_row);
    EXPECT_EQ(log.alignment.rate_shift_samples, 20 * per_row);
    EXPECT_EQ(log.alignment.evidence, "correlation");
    const std::vector<std::uint8_t> gap = log.gap_of({Signal::kRateX});
    EXPECT_EQ(std::find(gap.begin(), gap.end(), 1) - gap.begin(), 519 * per_row + 1) << "the gap moves with its rate";
  }
}

// The documentation of the measured flights says: "CSV row = odometry index i, RC index i - 2".
TEST(FlightLog, ReadsThePublishedMatFileAsItsCsvWithTheStickRowsTwoSamplesLater) {
  M100_SHARED_FILE_OR_SKIP(mat, "data/m100/ExperimentPitchRoll.mat");
  M100_SHARED_FILE_OR_SKIP(csv, "data/m100/pitch_roll.csv");
  const FlightLog from_mat = load(*open_log(mat.string()), parse_column_map(R"(
time = "Experiment1.Vicon.t"
[signals]
stick_pitch = { column = "Experiment1.RCData.channel[1]", offset = -1024 }
stick_roll = { column = "Experiment1.RCData.channel[2]", offset = -1024 }
attitude_roll = "Experiment1.rpy[1]"
rate_x = "Experiment1.IMU.w[1]"
)",
                                                                            "mat"));
  const FlightLog from_csv = load(*open_log(csv.string()), parse_column_map(R"(
time = "t_s"
[signals]
sequence = "seq"
stick_roll = { column = "rc_roll", offset = -1024 }
attitude_roll = "odom_roll_rad"
rate_x = "imu_wx_rad_s"
)",
                                                                            "csv"));
  EXPECT_EQ(from_mat.alignment.stick_shift_samples, 2);
  EXPECT_EQ(from_mat.alignment.rate_shift_samples, 25);
  EXPECT_EQ(from_mat.alignment.evidence, "sequence");
  EXPECT_EQ(from_csv.alignment.stick_shift_samples, 0);
  // Both logs start at their own first row; the CSV's first row is number 25 of the MAT-file.
  const double offset_s = 0.25;
  double worst_counts = 0;
  for (std::size_t k = 1000; k < 5000; ++k) {
    const std::size_t m = from_mat.index_of(from_csv.time_s(k) + offset_s);
    worst_counts =
        std::max(worst_counts, std::abs(from_mat.of(Signal::kStickRoll)[m] - from_csv.of(Signal::kStickRoll)[k]));
    EXPECT_NEAR(from_mat.of(Signal::kAttitudeRoll)[m], from_csv.of(Signal::kAttitudeRoll)[k], 0.012);
  }
  EXPECT_LT(worst_counts, 60.0);  // effect of a sub-sample clock offset on the steepest stick movement
}

}  // namespace
}  // namespace m100::lab::logs
