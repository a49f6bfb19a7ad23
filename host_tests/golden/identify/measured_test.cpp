// SPDX-License-Identifier: BSD-3-Clause
// The measured M100 flights. The limits are the goals that were set for the identification, stated beside each
// assertion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
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

/// The sentence about the pitch stick if its logged rows are changed; the rows are not in step with the samples.
/// @param changed  the counts in row `row`, of what was logged
std::string said_of_pitch(const std::filesystem::path& file, double (*changed)(std::size_t row, double counts)) {
  constexpr std::size_t kPitchStick = 2;  // column
  std::ifstream in(file);
  const std::string path = ::testing::TempDir() + "changed_stick.csv";
  std::ofstream out(path);
  std::string line;
  for (std::size_t row = 0; std::getline(in, line); ++row) {
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t column = 0; std::getline(cells, cell, ','); ++column) {
      out << (column == 0 ? "" : ",");
      row > 0 && column == kPitchStick ? out << changed(row, std::stod(cell)) : out << cell;
    }
    out << "\n";
  }
  out.close();
  for (const std::string& sentence : identify(path, "pitch", {12.0, 38.0}, {38.0, 55.5}).unexplained) {
    if (sentence.find("stick_pitch is logged") == 0) {
      return sentence.substr(0, sentence.find(" only"));
    }
  }
  return "";
}

TEST(MeasuredFlight, ACoarseStickIsSaid) {
  M100_SHARED_FILE_OR_SKIP(file, "data/m100/pitch_roll.csv");
  EXPECT_EQ(said_of_pitch(file, [](std::size_t, double counts) { return counts; }), "");
  EXPECT_EQ(said_of_pitch(file, [](std::size_t, double counts) { return 64.0 * std::round(counts / 64.0); }),
            "stick_pitch is logged in steps of 64 counts");
  EXPECT_EQ(said_of_pitch(file,
                          [](std::size_t row, double counts) {
                            static double held = 0.0;
                            held = row % 10 == 1 ? counts : held;
                            return held;
                          }),
            "stick_pitch is logged anew every 0.1 s");
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
