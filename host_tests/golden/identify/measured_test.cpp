// SPDX-License-Identifier: BSD-3-Clause
// The measured M100 flights. The limits are the goals that were set for the identification, stated beside each
// assertion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/data/log_ranges.h"
#include "host_tests/lab/identify/output/vehicle_update.h"
#include "host_tests/lab/identify/paper/paper_report.h"
#include "host_tests/lab/identify/prediction.h"
#include "host_tests/lab/identify/translation_pipeline.h"
#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/shared_files.h"
#include "host_tests/unit/identify/one_log.h"

namespace m100::lab::identify {
namespace {

/// @param neutral_counts  of the roll stick in the column map, added to the true one
IdentifyResult identify(const std::filesystem::path& file, const std::string& axis, Range train, Range validate,
                        double neutral_counts = 0.0) {
  logs::FlightLog log = logs::load(file.string(), "host_tests/lab/columns/m100_csv.toml");
  for (double& stick : log.of(logs::Signal::kStickRoll)) {
    stick -= neutral_counts;
  }
  Request request = about(log, axis, {"first_order"}, train, validate);
  request.refits = Request{}.refits;
  return identify_axis(request);
}

bool has(const IdentifyResult& result, const std::string& name) {
  return std::any_of(result.effects.begin(), result.effects.end(),
                     [&](const EffectResult& effect) { return effect.name == name; });
}

Interval dead_zone_of(const IdentifyResult& result) {
  for (const EffectResult& effect : result.effects) {
    if (effect.name == "dead_zone") {
      return effect.parameters[0].interval;
    }
  }
  return {};
}

double after_one_second(const IdentifyResult& result) { return result.final_model.horizon_rmse[kOneSecond]; }

struct Bar {
  const char* axis;
  double error_rad;  ///< asked for
  double after_one_second_rad;
  double declared_leaves_rad;  ///< at least; its trim is fitted, too
};
class MeasuredAxis : public ::testing::TestWithParam<Bar> {};
INSTANTIATE_TEST_SUITE_P(MeasuredFlight, MeasuredAxis,
                         ::testing::Values(Bar{"roll", 0.0072, 0.0085, 0.024}, Bar{"pitch", 0.0058, 0.0060, 0.0}),
                         [](const auto& tested) { return std::string(tested.param.axis); });

TEST_P(MeasuredAxis, HasASecondOrderAndADeadZone) {
  M100_SHARED_FILE_OR_SKIP(file, "data/m100/pitch_roll.csv");
  RecordProperty("paper", "III-D.2");
  const IdentifyResult result = identify(file, GetParam().axis, {12.0, 38.0}, {38.0, 55.5});
  EXPECT_LE(result.final_model.validation_rmse, GetParam().error_rad);
  EXPECT_GT(result.declared.validation_rmse, GetParam().declared_leaves_rad);
  EXPECT_TRUE(has(result, "second_order"));
  EXPECT_TRUE(has(result, "dead_zone"));
  EXPECT_LE(dead_zone_of(result).low, 17.0);
  EXPECT_GE(dead_zone_of(result).high, 18.0);
  EXPECT_LE(after_one_second(result), GetParam().after_one_second_rad);
}

// The answer depended on the neutral of the column map, which is arbitrary.
TEST(MeasuredFlight, TheNeutralOfTheMapMovesTheTrimAlone) {
  M100_SHARED_FILE_OR_SKIP(file, "data/m100/pitch_roll.csv");
  const auto effects = [](const IdentifyResult& result) {
    std::vector<std::string> out;
    for (const EffectResult& effect : result.effects) {
      if (effect.name != "trim_offset") {
        out.push_back(effect.name);
      }
    }
    return out;
  };
  const IdentifyResult here = identify(file, "roll", {12.0, 38.0}, {38.0, 55.5});
  for (const double neutral_counts : {-40.0, 40.0}) {
    const IdentifyResult there = identify(file, "roll", {12.0, 38.0}, {38.0, 55.5}, neutral_counts);
    EXPECT_EQ(effects(there), effects(here)) << neutral_counts;
    EXPECT_EQ(there.verdict, here.verdict) << neutral_counts;
    EXPECT_NEAR(there.final_model.validation_rmse, here.final_model.validation_rmse,
                0.01 * here.final_model.validation_rmse);
  }
}

using Cells = std::vector<double>;  ///< of one row of the log
constexpr std::size_t kTime = 0, kPitchStick = 2, kRollStick = 3, kPitch = 7;

/// The answer if one column of the log is changed. The rows are not in step with the samples.
IdentifyResult with_changed(const std::filesystem::path& file, const std::string& axis, std::size_t column,
                            const std::function<double(const Cells&)>& changed) {
  std::ifstream in(file);
  const std::string path = ::testing::TempDir() + "changed_column.csv";
  std::ofstream out(path);
  out.precision(12);
  std::string line;
  std::getline(in, line);
  out << line << "\n";
  while (std::getline(in, line)) {
    std::istringstream text(line);
    Cells cells;
    for (std::string cell; std::getline(text, cell, ',');) {
      cells.push_back(std::stod(cell));
    }
    cells[column] = changed(cells);
    for (std::size_t k = 0; k < cells.size(); ++k) {
      out << (k == 0 ? "" : ",") << cells[k];
    }
    out << "\n";
  }
  out.close();
  return identify(path, axis, {12.0, 38.0}, {38.0, 55.5});
}

/// The first unexplained sentence that begins so, up to " only" or " (".
std::string sentence(const IdentifyResult& result, const std::string& begin) {
  for (const std::string& text : result.unexplained) {
    if (text.starts_with(begin)) {
      return text.substr(0, std::min(text.find(" only"), text.find(" (")));
    }
  }
  return "";
}

TEST(MeasuredFlight, ACoarseStickIsSaid) {
  M100_SHARED_FILE_OR_SKIP(file, "data/m100/pitch_roll.csv");
  const auto said = [&file](const std::function<double(const Cells&)>& changed) {
    return sentence(with_changed(file, "pitch", kPitchStick, changed), "stick_pitch is logged");
  };
  EXPECT_EQ(said([](const Cells& cells) { return cells[kPitchStick]; }), "");
  EXPECT_EQ(said([](const Cells& cells) { return 64.0 * std::round(cells[kPitchStick] / 64.0); }),
            "stick_pitch is logged in steps of 64 counts");
  EXPECT_EQ(said([row = 0, held = 0.0](const Cells& cells) mutable {
              held = row++ % 10 == 0 ? cells[kPitchStick] : held;
              return held;
            }),
            "stick_pitch is logged anew every 0.1 s");
}

// A stick that was not logged for a second or two was "explained" by a gain, a frequency or a damping that changes, and
// a jump of the response by a gain: the verdict looked at one side of the change only.
TEST(MeasuredFlight, AnEventIsNotNamedAsAChange) {
  M100_SHARED_FILE_OR_SKIP(file, "data/m100/pitch_roll.csv");
  const IdentifyResult lost = with_changed(file, "roll", kRollStick, [](const Cells& cells) {
    return 50.6 < cells[kTime] && cells[kTime] < 52.1 ? 1024.0 : cells[kRollStick];
  });
  EXPECT_EQ(lost.verdict, "unexplained");
  EXPECT_TRUE(lost.changes.empty());
  const IdentifyResult jump = with_changed(
      file, "pitch", kPitch, [](const Cells& cells) { return cells[kPitch] + (cells[kTime] > 47.0 ? 0.02 : 0.0); });
  EXPECT_EQ(jump.verdict, "unexplained");
  EXPECT_TRUE(jump.changes.empty());
}

/// What the measured pitch loses if its restoring force grows with the cube of the angle.
struct Stiffening {
  struct State {
    double angle = 0.0, rate = 0.0;
  } linear, stiff;

  double operator()(const Cells& cells) {
    const double command = 8.8e-4 * (cells[kPitchStick] - 1024.0);
    advance(command, 0.0, linear);
    advance(command, 8.0, stiff);
    return cells[kPitch] + stiff.angle - linear.angle;
  }
  static void advance(double command, double per_rad2, State& state) {
    constexpr double kRow_s = 0.01, kFrequency_rad_s = 5.84, kDamping = 0.77;
    const double force = command - state.angle - per_rad2 * state.angle * state.angle * state.angle;
    state.rate += kRow_s * kFrequency_rad_s * (kFrequency_rad_s * force - 2.0 * kDamping * state.rate);
    state.angle += kRow_s * state.rate;
  }
};

// "Nothing missing" stood beside a page that drew what is left as a curve over the stick, with 37 % of it predicted.
TEST(MeasuredFlight, WhatFollowsTheStickIsSaid) {
  M100_SHARED_FILE_OR_SKIP(file, "data/m100/pitch_roll.csv");
  EXPECT_EQ(sentence(with_changed(file, "pitch", kPitch, Stiffening()), "the remainder"),
            "the remainder follows stick_pitch");
}

// Roll's delay was said to change at 8.0 s of the yaw flight, and pitch's dead zone at 9.7 s, while the hand that moves
// yaw becomes busier with them. Nothing changed in this flight.
TEST(MeasuredFlight, NothingChangesInFlight) {
  M100_SHARED_FILE_OR_SKIP(file, "data/m100/yaw.csv");
  EXPECT_TRUE(identify(file, "roll", {3.0, 40.0}, {40.0, 60.0}).changes.empty());
  EXPECT_TRUE(identify(file, "pitch", {3.0, 40.0}, {40.0, 60.0}).changes.empty());
}

TEST(MeasuredFlight, ClimbIsPredictedToTheStretchGoal) {
  M100_SHARED_FILE_OR_SKIP(file, "data/m100/height.csv");
  RecordProperty("paper", "III-D.3");
  const IdentifyResult result = identify(file, "climb", {4.5, 38.0}, {38.0, 64.5});
  EXPECT_LE(result.final_model.validation_rmse, 0.052) << "asked for: 0.068, stretch 0.052";
  // Catches an answer that is more certain than the flight allows: a trim predicts as well as the asymmetry.
  EXPECT_TRUE(std::any_of(result.not_separable.begin(), result.not_separable.end(), [](const auto& group) {
    return std::find(group.begin(), group.end(), "gain_asymmetry") != group.end() &&
           std::find(group.begin(), group.end(), "trim_offset") != group.end();
  }));
}

/// The declared and the identified model of the second aircraft, fitted to pieces of its flight.
struct SecondAircraft {
  model::Vehicle declared, identified;
  UnseenFlight unseen;  ///< the pieces between them
};

/// @param swapped  training and validation pieces are exchanged
SecondAircraft second_aircraft(const logs::FlightLog& log, bool swapped) {
  SecondAircraft out;
  for (const char* axis : {"roll", "pitch", "climb", "translation"}) {
    const bool translation = axis == std::string("translation");
    Request request = about(log, axis, {translation ? "rigid_body" : "first_order"});
    request.train = request.validate = {};
    split("alternate:6", "33:99", log, request);
    if (swapped) {
      std::swap(request.train, request.validate);
    }
    IdentifyResult result = translation ? identify_translation(request) : identify_axis(request);
    put_axis(result, out.identified);
    result.final_model = result.declared;
    put_axis(result, out.declared);
    out.unseen = {&log, request.validate};
  }
  return out;
}

// What the MPC controls: position and velocity from the sticks alone. An outside fit of first order leaves 0.092 m 1 s
// ahead; a model that names effects and predicts no better than that has found nothing.
TEST(SecondAircraft, IsPredictedBetterInXAndYAtEveryHorizon) {
  M100_SHARED_FILE_OR_SKIP(file, "data/m100/falcon2_height.csv");
  M100_SHARED_FILE_OR_SKIP(columns, "data/m100/falcon2.toml");
  const logs::FlightLog log = logs::load(file.string(), columns.string());
  for (const bool swapped : {false, true}) {
    const SecondAircraft aircraft = second_aircraft(log, swapped);
    const Prediction declared = predict_motion(aircraft.declared, aircraft.unseen);
    const Prediction identified = predict_motion(aircraft.identified, aircraft.unseen);
    for (std::size_t k = 0; k < kHorizons_s.size(); ++k) {
      EXPECT_LT(identified.position_m[k], declared.position_m[k]) << kHorizons_s[k] << " s ahead, swapped " << swapped;
      EXPECT_LT(identified.velocity_m_s[k], declared.velocity_m_s[k]) << kHorizons_s[k] << " s ahead, " << swapped;
    }
    EXPECT_LE(identified.position_m[kOneSecond], 0.092) << swapped;
  }
}

// Table I and the climb dynamics, to the three digits that the paper prints; the attitude's dynamics are others, and
// the simulator's scales have no data. With the five of the yaw flight these are the 28 numbers of Tables I and II.
TEST(PaperReproduction, GivesThePapersThreeDigits) {
  M100_SHARED_FILE_OR_SKIP(pitch_roll, "data/m100/ExperimentPitchRoll.mat");
  M100_SHARED_FILE_OR_SKIP(height, "data/m100/ExperimentHeight.mat");
  RecordProperty("paper", "Table I, III-D.3, Table II");
  const paper::Report report = paper::reproduce(pitch_roll.string(), height.string());
  EXPECT_EQ(report.stick_shift_samples, 2);
  EXPECT_EQ(report.evidence, "sequence");
  std::map<std::string, int> verdicts;
  for (const paper::ReproducedNumber& line : report.lines) {
    ++verdicts[paper::verdict(line)];
  }
  EXPECT_EQ(verdicts["reproduced"], 8) << "three scales, five numbers of the climb";
  EXPECT_EQ(verdicts["different: no cut of the published flight gives it"], 10);
  EXPECT_EQ(verdicts["no data published"], 4);
  const auto judged = [](double value) { return paper::verdict({"", 0.334, value, value, "why"}); };
  EXPECT_EQ(judged(0.3344), "reproduced");
  EXPECT_EQ(judged(0.3346), "different: why");
}

}  // namespace
}  // namespace m100::lab::identify
