// SPDX-License-Identifier: BSD-3-Clause
// Several flights of one vehicle in different winds: the drag is shared, the wind is not.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "host_tests/lab/hidden/hidden_flight.h"
#include "host_tests/lab/identify/translation_pipeline.h"
#include "host_tests/lab/inject/inject.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/join.h"
#include "host_tests/unit/identify/one_log.h"

namespace m100::lab::identify {
namespace {

constexpr double kDrag_per_s = 0.25;

/// A flight of 45 s of the vehicle with drag; a wind along x is injected as the tilt that holds against it.
logs::FlightLog flight(std::uint64_t seed, double wind_m_s2) {
  hidden::FlightPlan plan;
  plan.axis = "translation";
  plan.seed = seed;
  plan.hidden = {{"linear_drag", kDrag_per_s}};
  logs::FlightLog log = hidden::fly(plan);
  return wind_m_s2 == 0.0 ? log : hidden::inject(log, "translation", {}, {{"steady_wind", wind_m_s2}});
}

/// The same range of every flight, in the clock of each flight.
std::vector<Range> of_each(const logs::FlightLog& log, double from_s, double to_s) {
  std::vector<Range> out;
  for (std::size_t k = 0; k < std::max<std::size_t>(1, log.flights.size()); ++k) {
    out.emplace_back(logs::joined_time(log, k, from_s), logs::joined_time(log, k, to_s));
  }
  return out;
}

std::string sentence_with(const IdentifyResult& result, const std::string& words) {
  for (const Finding& finding : result.findings) {
    if (finding.text.find(words) != std::string::npos) {
      return finding.text;
    }
  }
  return "";
}

/// The number that follows "log K x" in a sentence.
double x_of(const std::string& sentence, int log) {
  const std::string key = "log " + std::to_string(log) + " x ";
  const std::size_t at = sentence.find(key);
  return at == std::string::npos ? -99.0 : std::stod(sentence.substr(at + key.size()));
}

double parameter(const IdentifyResult& result, const std::string& name) {
  for (const NamedValue& one : result.final_model.parameters) {
    if (one.name == name) {
      return one.value;
    }
  }
  return -99.0;
}

constexpr std::array<double, 3> kWinds_m_s2{0.4, -0.1, -0.3};

logs::FlightLog three_flights() {
  std::vector<logs::FlightLog> all;
  for (std::size_t k = 0; k < kWinds_m_s2.size(); ++k) {
    all.push_back(flight(31 + k, kWinds_m_s2[k]));
  }
  return logs::joined(std::move(all));
}

// Catches one wind for all flights: it leaves 0.5 m/s^2 in the residual, or is found as a change at a joint.
TEST(FlightWinds, AreFittedBesideWhatIsShared) {
  const logs::FlightLog log = three_flights();
  Request request = about(log, "translation", {"rigid_body", "linear_drag", "steady_wind"});
  request.train = of_each(log, 3.0, 28.0);
  request.validate = of_each(log, 28.0, 44.0);
  const IdentifyResult result = identify_translation(request);
  EXPECT_EQ(result.verdict, "nothing_missing") << ::testing::PrintToString(result.unexplained);
  EXPECT_TRUE(result.changes.empty());
  EXPECT_NEAR(parameter(result, "rate_per_s"), kDrag_per_s, 0.015) << "air of 0.05 m/s^2 over 75 s";
  EXPECT_NEAR(parameter(result, "accel_x_m_s2"), 0.0, 0.02) << "the mean of the three";
  const std::string said = sentence_with(result, "wind of its own");
  for (std::size_t k = 0; k < kWinds_m_s2.size(); ++k) {
    EXPECT_NEAR(x_of(said, static_cast<int>(k) + 1), kWinds_m_s2[k], 0.03) << said;
  }
  EXPECT_LT(result.final_model.validation_rmse, 0.08) << "the validation part of a flight has the flight's wind";
}

// Catches winds that are fitted although none was declared: the declared model does not contain them.
TEST(FlightWinds, DistinctWindsMustBeDeclared) {
  const logs::FlightLog log = three_flights();
  Request request = about(log, "translation", {"rigid_body", "linear_drag"});
  request.train = of_each(log, 3.0, 28.0);
  request.validate = of_each(log, 28.0, 44.0);
  const IdentifyResult result = identify_translation(request);
  EXPECT_NE(result.verdict, "nothing_missing");
  EXPECT_TRUE(result.changes.empty());
}

// Catches a wind per flight that absorbs the noise of the air: equal winds must be reported as one.
TEST(FlightWinds, ThatAreEqualAreOne) {
  std::vector<logs::FlightLog> all{flight(41, 0.2), flight(42, 0.2)};
  const logs::FlightLog log = logs::joined(std::move(all));
  Request request = about(log, "translation", {"rigid_body", "linear_drag", "steady_wind"});
  request.train = of_each(log, 3.0, 28.0);
  request.validate = of_each(log, 28.0, 44.0);
  const IdentifyResult result = identify_translation(request);
  EXPECT_EQ(result.verdict, "nothing_missing") << ::testing::PrintToString(result.unexplained);
  EXPECT_EQ(sentence_with(result, "wind of its own"), "");
  EXPECT_NEAR(parameter(result, "accel_x_m_s2"), 0.2, 0.02);
}

// The procedure of a wind tunnel: one model, and the wind of each flight from its first 10 s. The validation flight has
// a wind that no training flight had.
TEST(WindFromFirst, JudgesAFlightInAnotherWind) {
  const logs::FlightLog log = three_flights();
  const logs::FlightLog other = flight(34, 0.25);
  Request request = about(log, "translation", {"rigid_body", "linear_drag"});
  request.train = of_each(log, 3.0, 44.0);
  request.validation_log = &other;
  request.validate = {{3.0, 44.0}};
  request.wind_from_first_s = 10.0;
  const IdentifyResult result = identify_translation(request);
  EXPECT_EQ(result.verdict, "nothing_missing") << ::testing::PrintToString(result.unexplained);
  EXPECT_NEAR(parameter(result, "rate_per_s"), kDrag_per_s, 0.015);
  EXPECT_LT(result.validation_over_training, 1.3);
  const std::string training = sentence_with(result, "training: the wind of each flight");
  for (std::size_t k = 0; k < kWinds_m_s2.size(); ++k) {
    EXPECT_NEAR(x_of(training, static_cast<int>(k) + 1), kWinds_m_s2[k], 0.06) << training;
  }
  const std::string validation = sentence_with(result, "validation: the wind of each flight");
  EXPECT_NEAR(x_of(validation, 1), 0.25, 0.06) << validation;

  request.wind_from_first_s = 0.0;
  request.declared.emplace_back("steady_wind");
  const IdentifyResult without = identify_translation(request);
  EXPECT_GT(without.final_model.validation_rmse, 2.0 * result.final_model.validation_rmse)
      << "else the wind is no test";
}

TEST(WindFromFirst, IsRefusedBesideADeclaredWind) {
  const logs::FlightLog log = flight(31, 0.3);
  Request request = about(log, "translation", {"rigid_body", "steady_wind"});
  request.train = {{3.0, 28.0}};
  request.validate = {{28.0, 44.0}};
  request.wind_from_first_s = 10.0;
  EXPECT_THROW(static_cast<void>(identify_translation(request)), InputError);
}

}  // namespace
}  // namespace m100::lab::identify
