// SPDX-License-Identifier: BSD-3-Clause
// Translation: defects of a log, changes in flight, and forces that no effect of the table explains.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>
#include <string>

#include "host_tests/lab/identify/data/translation_data.h"
#include "host_tests/lab/identify/output/vehicle_update.h"
#include "host_tests/lab/identify/translation_pipeline.h"
#include "host_tests/unit/identify/one_log.h"

namespace m100::lab::identify {
namespace {

using logs::FlightLog;
using logs::Signal;

IdentifyResult ask(const FlightLog& log, std::size_t refits = 0) {
  Request request = about(log, "translation", {"rigid_body"});
  request.refits = refits;
  return identify_translation(request);
}

/// Adds an acceleration to the logged motion along one axis.
void push(FlightLog& log, int axis, const std::function<double(std::size_t)>& acceleration) {
  std::vector<double>& velocity = log.of(logs::offset(Signal::kVelocityX, axis));
  double sum = 0.0;
  for (std::size_t k = 0; k < log.size; ++k) {
    sum += log.period_s * acceleration(k);
    velocity[k] += sum;
  }
}

struct Case {
  const char* name;
  std::function<void(FlightLog&)> harm;
  const char* must_say;
};

class TranslationSideFindings : public ::testing::TestWithParam<Case> {};

TEST_P(TranslationSideFindings, IsSaidByName) {
  FlightLog log = healthy_flight("translation", 707);
  GetParam().harm(log);
  const IdentifyResult result = ask(log);
  EXPECT_NE(result.verdict, "nothing_missing") << text_of(result);
  EXPECT_NE(text_of(result, false).find(GetParam().must_say), std::string::npos) << text_of(result);
}

void scale(FlightLog& log, Signal signal, double factor) {
  for (double& value : log.of(signal)) {
    value *= factor;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Table, TranslationSideFindings,
    ::testing::Values(
        Case{"RollReversed", [](FlightLog& log) { scale(log, Signal::kAttitudeRoll, -1.0); }, "sign_reversed: "},
        Case{"PitchReversed", [](FlightLog& log) { scale(log, Signal::kAttitudePitch, -1.0); }, "sign_reversed: "},
        Case{"RollAndPitchExchanged",
             [](FlightLog& log) { std::swap(log.of(Signal::kAttitudeRoll), log.of(Signal::kAttitudePitch)); },
             "swapped_axes: "},
        Case{"NorthAndEastExchanged",
             [](FlightLog& log) {
               for (const auto& [x, y] : {std::pair{Signal::kPositionX, Signal::kPositionY},
                                          std::pair{Signal::kVelocityX, Signal::kVelocityY}}) {
                 std::swap(log.of(x), log.of(y));  // north is x, and west, which is minus east, is y
                 for (const Signal signal : {x, y}) {
                   scale(log, signal, -1.0);
                 }
               }
             },
             "swapped_axes: the acceleration fits north and east exchanged"},
        Case{"Degrees",
             [](FlightLog& log) {
               scale(log, Signal::kAttitudeRoll, 180.0 / std::numbers::pi);
               scale(log, Signal::kAttitudePitch, 180.0 / std::numbers::pi);
             },
             "wrong_unit: "},
        Case{"WindBegins",
             [](FlightLog& log) { push(log, 0, [&](std::size_t k) { return log.time_s(k) > 21.0 ? 0.5 : 0.0; }); },
             "changed steady_wind at 2"},
        Case{"Tether",
             [](FlightLog& log) {
               const std::vector<double> x = log.of(Signal::kPositionX);
               const std::vector<double> y = log.of(Signal::kPositionY);
               push(log, 0, [&](std::size_t k) { return -0.6 * x[k]; });
               push(log, 1, [&](std::size_t k) { return -0.6 * y[k]; });
             },
             "position_force: "}),
    [](const auto& tested) { return std::string(tested.param.name); });

// Catches a date without an interval, and a structure that is chosen across a change and names an effect that mimics
// it.
TEST(TranslationChange, IsDatedAndNothingElseIsNamed) {
  int inside = 0;
  for (std::uint64_t seed = 811; seed <= 816; ++seed) {
    FlightLog log = healthy_flight("translation", seed);
    const double at_s = 14.0 + 2.11 * static_cast<double>(seed - 811);
    push(log, 0, [&](std::size_t k) { return log.time_s(k) > at_s ? 0.6 : 0.0; });
    const IdentifyResult result = ask(log);
    EXPECT_EQ(result.verdict, "explained") << text_of(result);
    EXPECT_TRUE(result.effects.empty()) << text_of(result);
    ASSERT_EQ(result.changes.size(), 1U) << text_of(result);
    EXPECT_EQ(result.changes[0].name, "steady_wind");
    EXPECT_LT(result.changes[0].high_s - result.changes[0].low_s, 0.6);
    inside += result.changes[0].low_s <= at_s && at_s <= result.changes[0].high_s ? 1 : 0;
  }
  EXPECT_GE(inside, 5);
}

// Catches a heading that is used where it was not sampled, because the thrust's direction was logged beside it.
TEST(TranslationData, AGapOfTheHeadingCountsBesideADirectionOfTheThrust) {
  FlightLog log = healthy_flight("translation", 808);
  log.of(Signal::kThrustDirX) = log.of(Signal::kThrustDirY) = std::vector<double>(log.size, 0.0);
  log.of(Signal::kThrustDirZ).assign(log.size, 1.0);
  log.signal_gap[Signal::kAttitudeYaw].assign(log.size, 0);
  log.signal_gap[Signal::kAttitudeYaw][2000] = 1;
  const TranslationData data(log, ThrustSource::kWeight);
  EXPECT_EQ(data.valid[2000], 0);
  EXPECT_EQ(data.valid[1000], 1);
}

// Frozen samples must be reported and excluded. Outside of the ranges neither they nor outliers matter.
TEST(TranslationSideFindings, SpoiltSamplesAreKeptOutWhereTheyMatter) {
  const FlightLog clean = healthy_flight("translation", 808);
  const auto spoil = [&](std::size_t from) {
    FlightLog log = clean;
    log.signal_gap[Signal::kAttitudeRoll].assign(log.size, 0);  // as in a log that was read from a file
    for (const Signal signal : {Signal::kVelocityX, Signal::kVelocityY}) {
      std::vector<double>& values = log.of(signal);
      std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(from), 60, values[from]);
    }
    return log;
  };
  const auto has_finding = [](const IdentifyResult& result, const char* what) {
    return std::any_of(result.findings.begin(), result.findings.end(),
                       [&](const Finding& finding) { return finding.what == what; });
  };
  const double error = ask(clean).final_model.validation_rmse;
  const IdentifyResult inside = ask(spoil(3300));
  EXPECT_TRUE(has_finding(inside, "frozen")) << text_of(inside);
  EXPECT_NE(inside.verdict, "nothing_missing");
  EXPECT_LT(inside.final_model.validation_rmse, 1.1 * error) << "frozen samples count as measurements";
  FlightLog outside = spoil(4440);
  outside.of(Signal::kVelocityX)[100] += 5.0;
  const IdentifyResult result = ask(outside);
  EXPECT_FALSE(has_finding(result, "frozen")) << text_of(result);
  EXPECT_FALSE(has_finding(result, "outliers")) << text_of(result);
  EXPECT_EQ(result.final_model.validation_rmse, error);
}

/// A vehicle that climbs and tilts at the same time, without air; velocity noise 2 mm/s.
FlightLog climbing_turns() {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  FlightLog log;
  log.size = 4500;
  log.gap.assign(log.size, 0);
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 0.002);
  std::array<double, 3> velocity{};
  for (std::size_t k = 0; k < log.size; ++k) {
    const double t_s = log.time_s(k);
    const double roll = 0.2 * std::sin(kTurn * 0.7 * t_s) + 0.1 * std::sin(kTurn * 0.13 * t_s);
    const double pitch = 0.25 * std::sin(kTurn * 0.9 * t_s + 1.0);
    const double up = 2.5 * std::sin(kTurn * 1.3 * t_s);
    const double lift = kStandardGravity_m_s2 + up;
    const std::array<double, 3> acceleration{lift * std::tan(pitch), -lift * std::tan(roll) / std::cos(pitch), up};
    log.of(Signal::kAttitudeRoll).push_back(roll);
    log.of(Signal::kAttitudePitch).push_back(pitch);
    log.of(Signal::kAttitudeYaw).push_back(0.0);
    for (int c = 0; c < 3; ++c) {
      const auto axis = static_cast<std::size_t>(c);
      log.of(logs::offset(Signal::kVelocityX, c))
          .push_back(velocity[axis] + 0.5 * log.period_s * acceleration[axis] + noise(random));
      velocity[axis] += log.period_s * acceleration[axis];
    }
  }
  return log;
}

// Catches a thrust that is filtered before it is multiplied by the tilt, and then again: the residual was 0.021 instead
// of 0.007 m/s^2 and was called periodic.
TEST(ThrustSource, OfAClimbingVehicleIsFilteredOnce) {
  const IdentifyResult result = ask(climbing_turns());
  EXPECT_LT(result.declared.validation_rmse, 0.012);
  EXPECT_EQ(result.verdict, "nothing_missing") << text_of(result);
}

// Catches an accelerometer that reads 0.4 m/s^2 too much taken for thrust: a tilt gain of 0.96 was named.
TEST(ThrustSource, TheAccelerometersErrorIsNoTiltGain) {
  FlightLog log = climbing_turns();
  for (std::size_t k = 0; k < log.size; ++k) {
    const double up = 2.5 * std::sin(2.0 * std::numbers::pi * 1.3 * log.time_s(k));
    const double upright = std::cos(log.of(Signal::kAttitudeRoll)[k]) * std::cos(log.of(Signal::kAttitudePitch)[k]);
    log.of(Signal::kForceX).push_back(0.0);
    log.of(Signal::kForceY).push_back(0.0);
    log.of(Signal::kForceZ).push_back((kStandardGravity_m_s2 + up) / upright + 0.4);
  }
  const IdentifyResult result = ask(log);
  EXPECT_LT(result.declared.validation_rmse, 0.012);
  EXPECT_EQ(result.verdict, "nothing_missing") << text_of(result);
}

// Catches a velocity that was captured as a mean but is compared with an unaveraged prediction.
TEST(CapturedVelocity, IsComparedWithTheSameMeanOfThePrediction) {
  FlightLog log = climbing_turns();
  constexpr std::size_t kHalf = 5;
  for (const Signal signal : {Signal::kVelocityX, Signal::kVelocityY}) {
    const std::vector<double> old = log.of(signal);
    for (std::size_t k = kHalf; k + kHalf < log.size; ++k) {
      double sum = 0.5 * (old[k - kHalf] + old[k + kHalf]);
      sum += std::accumulate(&old[k - kHalf + 1], &old[k + kHalf], 0.0);
      log.of(signal)[k] = sum / static_cast<double>(2 * kHalf);
    }
  }
  EXPECT_GT(ask(log).declared.validation_rmse, 0.02);
  log.velocity_mean_s = 0.1;
  EXPECT_LT(ask(log).declared.validation_rmse, 0.012);
}

// Catches a scan that takes gusts for a change, and a vehicle that is flown back for a tethered one.
TEST(TranslationSideFindings, HealthyFlightsHaveNoSideFindings) {
  for (std::uint64_t seed = 801; seed <= 806; ++seed) {
    const IdentifyResult result = ask(healthy_flight("translation", seed));
    EXPECT_TRUE(result.changes.empty()) << "seed " << seed << ": " << text_of(result);
    EXPECT_EQ(result.verdict, "nothing_missing") << "seed " << seed << ": " << text_of(result);
  }
}

TEST(Refitted, SaysWhatWasBelievedAndWhetherItMatters) {
  IdentifyResult result;
  result.axis = "roll";
  result.final_model.structure = {"second_order", "transport_delay"};
  result.final_model.parameters = {
      {"gain", 9e-4}, {"natural_frequency_rad_s", 8.0}, {"damping_ratio", 0.7}, {"delay_s", 0.12}};
  result.final_intervals = {{"gain", {9e-4, 8.8e-4, 9.2e-4}},
                            {"natural_frequency_rad_s", {8.0, 7.5, 8.5}},
                            {"damping_ratio", {0.7, 0.6, 0.8}},
                            {"delay_s", {0.12, 0.11, 0.13}}};
  model::Vehicle believed;
  believed.roll.scale_per_count = 9e-4;
  believed.roll.natural_frequency_rad_s = 8.2;
  believed.roll.damping_ratio = 0.7;
  believed.roll.transport_delay_s = 0.055;
  const std::vector<Refitted> out = refitted(believed, result);
  ASSERT_EQ(out.size(), 4U);
  for (const Refitted& one : out) {
    EXPECT_EQ(one.matters, one.parameter == "transport_delay_s") << one.parameter;
  }
  EXPECT_EQ(out[3].believed, 0.055);
  EXPECT_EQ(out[3].found.high, 0.13);
}

}  // namespace
}  // namespace m100::lab::identify
