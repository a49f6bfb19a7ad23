// SPDX-License-Identifier: BSD-3-Clause
// Only a model that was tested gets the verdict "nothing missing": logs with either kind of input, validation parts
// that test nothing, spectral lines that are spread over pieces of the log.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "host_tests/lab/hidden/hidden_flight.h"
#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/data/log_defects.h"
#include "host_tests/lab/identify/residual_tests/residual_test.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/property/identify/synthetic_axis.h"
#include "host_tests/unit/identify/one_log.h"

namespace m100::lab::identify {
namespace {

using host_tests::SyntheticAxis;
using logs::FlightLog;
using logs::Signal;

IdentifyResult ask(const FlightLog& log, const std::string& axis = "roll", const FlightLog* other = nullptr) {
  Request request = about(log, axis, {"second_order", "transport_delay"});
  request.validation_log = other != nullptr ? other : &log;
  return identify_axis(request);
}

bool found(const IdentifyResult& result, const char* what) {
  return std::any_of(result.findings.begin(), result.findings.end(),
                     [&](const Finding& finding) { return finding.what == what; });
}

void move(FlightLog& log, Signal from, Signal to, double factor) {
  log.of(to) = log.of(from);
  log.of(from).clear();
  for (double& value : log.of(to)) {
    value *= factor;
  }
}

struct YawCase {
  const char* name;
  Signal input;
  double input_factor;
  double rate_factor;
  bool reversed;
};

class YawLog : public ::testing::TestWithParam<YawCase> {};

// A stick is positive to the right, a rate to the left; a commanded rate has the sign of the rate itself.
TEST_P(YawLog, KnowsItsHealthySign) {
  SyntheticAxis vehicle;
  FlightLog log = vehicle.fly();
  log.of(Signal::kStickPitch).clear();
  move(log, Signal::kStickRoll, GetParam().input, GetParam().input_factor);
  move(log, Signal::kAttitudeRoll, Signal::kRateZ, GetParam().rate_factor);
  const IdentifyResult result = ask(log, "yaw_rate");
  EXPECT_EQ(found(result, "sign_reversed"), GetParam().reversed) << text_of(result);
  EXPECT_FALSE(found(result, "wrong_unit")) << text_of(result);
  EXPECT_EQ(result.verdict, GetParam().reversed ? "unexplained" : "nothing_missing") << text_of(result);
}

INSTANTIATE_TEST_SUITE_P(Table, YawLog,
                         ::testing::Values(YawCase{"Command", Signal::kCommandYawRate, 8.5e-4, 1.0, false},
                                           YawCase{"CommandReversed", Signal::kCommandYawRate, -8.5e-4, 1.0, true},
                                           YawCase{"Stick", Signal::kStickYaw, 1.0, -1.0, false},
                                           YawCase{"StickReversed", Signal::kStickYaw, 1.0, 1.0, true}),
                         [](const auto& tested) { return tested.param.name; });

// The size of an angle shows degrees only beyond half a turn; below that the gain shows them.
TEST(Units, AGainThatNoAircraftHasIsAWrongUnit) {
  const SyntheticAxis vehicle;
  const auto verdict = [&](Signal input, double input_factor, Signal response, double response_factor,
                           const char* axis) {
    FlightLog log = vehicle.fly();
    log.of(Signal::kStickPitch).clear();
    if (input != Signal::kStickRoll) {
      move(log, Signal::kStickRoll, input, input_factor);
    }
    if (response != Signal::kAttitudeRoll) {
      move(log, Signal::kAttitudeRoll, response, response_factor);
    }
    return ask(log, axis);
  };
  const double degrees = 180.0 / std::numbers::pi;
  const auto turned = verdict(Signal::kStickYaw, 1.0, Signal::kRateZ, -4.0 * degrees, "yaw_rate");
  EXPECT_TRUE(found(turned, "wrong_unit")) << text_of(turned);
  const auto commanded = verdict(Signal::kCommandYawRate, 8.5e-4, Signal::kRateZ, degrees, "yaw_rate");
  EXPECT_TRUE(found(commanded, "wrong_unit")) << text_of(commanded);
  const auto command_in_degrees = verdict(Signal::kCommandRoll, 8.5e-4 * degrees, Signal::kAttitudeRoll, 1.0, "roll");
  EXPECT_TRUE(found(command_in_degrees, "wrong_unit")) << text_of(command_in_degrees);
  const auto quick = verdict(Signal::kStickYaw, 1.0, Signal::kRateZ, -4.0, "yaw_rate");
  EXPECT_FALSE(found(quick, "wrong_unit")) << text_of(quick);
}

// One bad sample beyond half a turn must not convert the whole log from degrees to radians.
TEST(Units, OneOutlierDoesNotMakeDegrees) {
  FlightLog log = SyntheticAxis{}.fly();
  std::vector<double> angle = log.of(Signal::kAttitudeRoll);
  angle[700] = 7.0;
  const std::vector<double> before = angle;
  EXPECT_TRUE(repair_units(angle, std::vector<char>(angle.size(), 1), "attitude_roll").empty());
  EXPECT_EQ(angle, before);
}

// Catches the verdict "nothing missing" from a validation part in which the stick rests: the model only predicts rest.
TEST(ValidationPart, ThatNeverMovesTheStickTestsNothing) {
  const FlightLog flown = SyntheticAxis{}.fly();
  FlightLog rested = flown;
  SyntheticAxis vehicle;
  vehicle.gain_rad = 0.0;  // only air
  rested.of(Signal::kAttitudeRoll) = vehicle.fly().of(Signal::kAttitudeRoll);
  std::fill(rested.of(Signal::kStickRoll).begin(), rested.of(Signal::kStickRoll).end(), 0.0);
  const IdentifyResult result = ask(flown, "roll", &rested);
  EXPECT_EQ(result.verdict, "unexplained") << text_of(result);
  EXPECT_NE(text_of(result).find("it tests nothing"), std::string::npos) << text_of(result);
}

// The longer side of a change may have too few data for a study of its own; the change must still be reported.
TEST(Change, WithALongerSideOfGapsIsStillFound) {
  SyntheticAxis vehicle;
  vehicle.change_s = 16.0;
  vehicle.hidden_later = {{"gain", 1.4}};
  FlightLog log = vehicle.fly();
  std::fill(log.gap.begin() + 1900, log.gap.begin() + 3000, std::uint8_t{1});
  const IdentifyResult result = ask(log);
  ASSERT_EQ(result.changes.size(), 1U) << text_of(result);
  EXPECT_EQ(result.changes[0].name, "gain");
  EXPECT_NEAR(result.changes[0].at_s, 16.0, 1.0);
}

// Samples outside the ranges are not judged: a landing may be rough.
TEST(SpoiltSamples, OutsideOfTheRangesDoNotMatter) {
  const FlightLog clean = SyntheticAxis{}.fly();
  FlightLog spoilt = clean;
  std::vector<double>& angle = spoilt.of(Signal::kAttitudeRoll);
  for (std::size_t i = 20; i < 260; i += 20) {
    angle[i] = 9.0;  // also beyond half a turn
  }
  std::fill(angle.begin() + 4420, angle.begin() + 4490, angle[4420]);
  const IdentifyResult result = ask(spoilt);
  EXPECT_FALSE(found(result, "outliers")) << text_of(result);
  EXPECT_FALSE(found(result, "frozen")) << text_of(result);
  EXPECT_FALSE(found(result, "wrong_unit")) << text_of(result);
  EXPECT_EQ(result.verdict, "nothing_missing") << text_of(result);
  EXPECT_EQ(result.final_model.validation_rmse, ask(clean).final_model.validation_rmse);
  angle[1000] = 9.0;
  EXPECT_TRUE(found(ask(spoilt), "outliers"));
}

TEST(ValidationLog, OfOtherInputsIsRefused) {
  const FlightLog sticks = SyntheticAxis{}.fly();
  FlightLog commands = sticks;
  commands.of(Signal::kStickPitch).clear();
  move(commands, Signal::kStickRoll, Signal::kCommandRoll, 8.5e-4);
  EXPECT_THROW(ask(sticks, "roll", &commands), InputError);
}

// Catches columns that are mixed up or read beyond their end (seen by the address sanitizer).
TEST(ValidationLog, MayHaveOtherChannels) {
  FlightLog rich = SyntheticAxis{}.fly();
  rich.extra["battery"].assign(rich.size, 12.0);
  rich.of(Signal::kStickYaw).assign(rich.size, 0.0);
  FlightLog poor = SyntheticAxis{}.fly();
  poor.of(Signal::kStickPitch).clear();
  for (const auto& [training, validation] : {std::pair{&rich, &poor}, std::pair{&poor, &rich}}) {
    const IdentifyResult result = ask(*training, "roll", validation);
    EXPECT_EQ(result.verdict, "nothing_missing") << text_of(result);
  }
}

TEST(Merge, MatchesGroupsByTheirSource) {
  std::vector<RegressorGroup> groups{{"stick", {{1.0}, {2.0}}}, {"battery", {{3.0}}}, {"time", {{4.0}}}};
  merge(groups, {{"stick", {{10.0}, {20.0}}}, {"time", {{40.0}}}, {"wind", {{50.0}}}});
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_EQ(groups[0].source, "stick");
  EXPECT_EQ(groups[0].columns, (std::vector<std::vector<double>>{{1.0, 10.0}, {2.0, 20.0}}));
  EXPECT_EQ(groups[1].source, "time");
  EXPECT_EQ(groups[1].columns, (std::vector<std::vector<double>>{{4.0, 40.0}}));
}

struct Line {
  const char* name;
  double hz;
  double length_s;
  double piece_s;  ///< pieces alternate between the parts; all training pieces come first
  bool two_logs;
};

class ResidualLine : public ::testing::TestWithParam<Line> {
 protected:
  /// Air of 4 mrad, sensor noise of 2 mrad and a sine, in the order of time.
  static std::vector<double> flown(double sine_rad, const Line& line, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const double keep = std::exp(-0.01 / 0.4);
    double air = 0.004 * normal(random);
    std::vector<double> all;
    for (double t_s = 0.0; t_s < line.length_s; t_s += 0.01) {
      const double phase = line.two_logs && t_s >= 0.5 * line.length_s ? 2.6 : 0.0;
      all.push_back(air + 0.002 * normal(random) + sine_rad * std::sin(2.0 * std::numbers::pi * line.hz * t_s + phase));
      air = keep * air + 0.004 * std::sqrt(1.0 - keep * keep) * normal(random);
    }
    return all;
  }
  static void append_row(ResidualInput& input, double residual, double time_s, bool of_second_log) {
    if (input.residuals[0].size() % 250 == 0) {
      input.block_begin.push_back(input.residuals[0].size());
    }
    input.time_s.push_back(time_s);
    input.flight.push_back(of_second_log ? 1 : 0);
    input.residuals[0].push_back(residual);
  }
  /// The residual of a model of that flight, in the order of the parts.
  static ResidualInput remainder(double sine_rad, const Line& line, std::uint64_t seed) {
    const std::vector<double> all = flown(sine_rad, line, seed);
    ResidualInput input;
    input.residuals.resize(1);
    const auto length = static_cast<std::size_t>(std::lround(line.piece_s / 0.01));
    for (const std::size_t turn : {0U, 1U}) {
      for (std::size_t k = 0; k < all.size(); ++k) {
        const bool second = line.two_logs && 2 * k >= all.size();
        if (k / length % 2 == turn) {
          append_row(input, all[k], 0.01 * static_cast<double>(second ? k - all.size() / 2 : k), second);
        }
      }
    }
    return input;
  }
  static std::string line_in(const ResidualInput& input) {
    for (const std::string& text : test_residual(input, {}).unexplained) {
      if (text.rfind("periodic", 0) == 0) {
        return text;
      }
    }
    return "";
  }
};

// Catches a phase that is computed from the row instead of the time, and bins that are wider than a line.
TEST_P(ResidualLine, IsFoundWhereverItsPiecesLie) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::string text = line_in(remainder(0.0057, GetParam(), seed));
    ASSERT_NE(text, "") << "seed " << seed;
    // Tolerance: half the spacing of independent frequencies in the shortest case, 60 s.
    EXPECT_NEAR(std::stod(text.substr(std::string("periodic ").size())), GetParam().hz, 0.01) << "seed " << seed;
  }
}

TEST_P(ResidualLine, IsNotFoundInAir) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    alarms += line_in(remainder(0.0, GetParam(), seed)).empty() ? 0 : 1;
  }
  EXPECT_EQ(alarms, 0);
}

INSTANTIATE_TEST_SUITE_P(Table, ResidualLine,
                         ::testing::Values(Line{"Alternate6", 0.25, 60.0, 6.0, false},
                                           Line{"Alternate7", 0.375, 60.0, 7.0, false},
                                           Line{"FiveMinutes", 0.311, 300.0, 150.0, false},
                                           Line{"TwoLogs", 0.45, 120.0, 60.0, true}),
                         [](const auto& tested) { return tested.param.name; });

// A response that reverses its sign in flight has another gain of nearly the same size. Catches an analysis that calls
// this "no answer".
TEST(Changes, AReversedAnswerIsAnAnswer) {
  SyntheticAxis vehicle;
  vehicle.change_s = 24.0;
  vehicle.hidden_later = {{"gain", -0.9}};
  const IdentifyResult result = ask(vehicle.fly());
  EXPECT_EQ(text_of(result).find("does not answer"), std::string::npos) << text_of(result);
  ASSERT_EQ(result.changes.size(), 1U) << text_of(result);
  EXPECT_EQ(result.changes.front().name, "gain") << text_of(result);
  EXPECT_NEAR(result.changes.front().at_s, 24.0, 0.5);
}

// Catches a residual that passes because there was too little of it to test.
TEST(Residual, ThatWasNotTestedIsNoCleanOne) {
  ResidualInput input;
  input.residuals.push_back(std::vector<double>(1000, 0.001));
  input.block_begin = {0, 250, 500, 750};
  const ResidualFinding finding = test_residual(input, {});
  ASSERT_EQ(finding.unexplained.size(), 1U);
  EXPECT_NE(finding.unexplained[0].find("not tested"), std::string::npos) << finding.unexplained[0];
}

}  // namespace
}  // namespace m100::lab::identify
