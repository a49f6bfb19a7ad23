// SPDX-License-Identifier: BSD-3-Clause
// The answer is a function of the data and of the final model: neither the neutral of the column map nor the way in
// which the model was found matters.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/property/identify/synthetic_axis.h"
#include "host_tests/unit/identify/one_log.h"

namespace m100::lab::identify {
namespace {

using host_tests::SyntheticAxis;
using logs::FlightLog;
using logs::Signal;

std::vector<std::string> effects_beside_trim(const IdentifyResult& result) {
  std::vector<std::string> out;
  for (const EffectResult& effect : result.effects) {
    if (effect.name != "trim_offset") {
      out.push_back(effect.name);
    }
  }
  return out;
}

double trim_of(const IdentifyResult& result) {
  const auto found = std::find_if(result.final_model.parameters.begin(), result.final_model.parameters.end(),
                                  [](const NamedValue& one) { return one.name == "offset_counts"; });
  return found == result.final_model.parameters.end() ? 0.0 : found->value;
}

FlightLog with_neutral_at(FlightLog log, double counts) {
  for (double& stick : log.of(Signal::kStickRoll)) {
    stick -= counts;
  }
  return log;
}

class MapNeutral : public ::testing::TestWithParam<double> {};

// Catches a fit without a trim, or one that starts or ends where the map has its neutral: the validation error was
// 0.014 or 0.023, depending on the map.
TEST_P(MapNeutral, ChangesTheTrimAlone) {
  SyntheticAxis vehicle = SyntheticAxis::random(5);
  vehicle.hidden = {{"dead_zone", 24.0}, {"trim_offset", 10.0}};
  vehicle.air_rad = 0.008;
  const FlightLog log = vehicle.fly();
  const FlightLog moved = with_neutral_at(log, GetParam());
  const IdentifyResult here = identify_axis(about(log, "roll", {"second_order", "transport_delay"}));
  const IdentifyResult there = identify_axis(about(moved, "roll", {"second_order", "transport_delay"}));
  EXPECT_EQ(effects_beside_trim(here), std::vector<std::string>{"dead_zone"}) << text_of(here);
  EXPECT_EQ(effects_beside_trim(there), effects_beside_trim(here)) << text_of(there);
  EXPECT_EQ(there.verdict, here.verdict) << text_of(there);
  EXPECT_NEAR(trim_of(there), trim_of(here) - GetParam(), 0.1);
  EXPECT_NEAR(there.declared.validation_rmse, here.declared.validation_rmse, 0.01 * here.declared.validation_rmse);
  EXPECT_NEAR(there.final_model.validation_rmse, here.final_model.validation_rmse,
              0.01 * here.final_model.validation_rmse);
}
INSTANTIATE_TEST_SUITE_P(Table, MapNeutral, ::testing::Values(-90.0, -20.0, 62.0));

// The smallest trim that is an effect is three counts; the air must not make one.
TEST(Trim, IsAnEffectWhereItLeavesTheDeclaredValue) {
  for (const std::uint64_t seed : {11U, 12U, 13U}) {
    SyntheticAxis vehicle = SyntheticAxis::random(seed);
    const IdentifyResult none = identify_axis(about(vehicle.fly(), "roll", {"second_order", "transport_delay"}));
    EXPECT_EQ(none.verdict, "nothing_missing") << text_of(none);
    vehicle.hidden = {{"trim_offset", 20.0}};
    const FlightLog log = vehicle.fly();
    const IdentifyResult found = identify_axis(about(log, "roll", {"second_order", "transport_delay"}));
    ASSERT_EQ(found.effects.size(), 1U) << text_of(found);
    EXPECT_EQ(found.effects[0].name, "trim_offset");
    const IdentifyResult declared =
        identify_axis(about(log, "roll", {"second_order", "transport_delay", "trim_offset"}));
    EXPECT_EQ(declared.verdict, "nothing_missing") << text_of(declared);
    EXPECT_EQ(declared.final_model.validation_rmse, found.final_model.validation_rmse);
  }
}

struct Two {
  const char* name;
  std::map<std::string, double> hidden;
  const char* strong;
  std::vector<std::string> weak;  ///< the other one, if it is named
};
class FoundOrDeclared : public ::testing::TestWithParam<Two> {};

// The second effect is certain and barely large enough for a name, or barely too small. Catches a test of the residual
// that is skipped where the first one was found.
TEST_P(FoundOrDeclared, TheFinalModelIsTested) {
  SyntheticAxis vehicle = SyntheticAxis::random(21);
  vehicle.hidden = GetParam().hidden;
  vehicle.air_rad = 0.012;
  const FlightLog log = vehicle.fly();
  const IdentifyResult found = identify_axis(about(log, "roll", {"second_order", "transport_delay"}));
  const IdentifyResult declared =
      identify_axis(about(log, "roll", {"second_order", "transport_delay", GetParam().strong}));
  std::vector<std::string> both{GetParam().strong};
  both.insert(both.end(), GetParam().weak.begin(), GetParam().weak.end());
  EXPECT_EQ(effects_beside_trim(found), both) << text_of(found);
  EXPECT_EQ(effects_beside_trim(declared), GetParam().weak) << text_of(declared);
  for (const IdentifyResult& result : {found, declared}) {
    EXPECT_EQ(result.verdict, GetParam().weak.empty() ? "unexplained" : "explained") << text_of(result);
    EXPECT_EQ(text_of(result).find("cross_axis is certain") == std::string::npos, !GetParam().weak.empty());
  }
}
INSTANTIATE_TEST_SUITE_P(
    Table, FoundOrDeclared,
    ::testing::Values(
        Two{"AsymmetryAndCross", {{"gain_asymmetry", 1.4}, {"cross_axis", 0.04}}, "gain_asymmetry", {}},
        Two{"CurveAndLessCross", {{"stick_curve", 1.4}, {"cross_axis", 0.036}}, "stick_curve", {}},
        Two{"CurveAndCross", {{"stick_curve", 1.4}, {"cross_axis", 0.04}}, "stick_curve", {"cross_axis"}}),
    [](const auto& tested) { return std::string(tested.param.name); });

// Catches "explained" for an effect that the unseen commands cannot test: a limit of 0.16 rad, commands to 0.1.
TEST(UnseenData, ALimitThatTheyNeverReachIsNotTested) {
  for (const std::uint64_t seed : {31U, 32U, 33U}) {
    SyntheticAxis vehicle = SyntheticAxis::random(seed);
    vehicle.hidden = {{"saturation", 0.16}};
    const std::vector<std::string> declared{"second_order", "transport_delay"};
    const IdentifyResult tested = identify_axis(about(vehicle.fly(), "roll", declared));
    EXPECT_EQ(tested.verdict, "explained") << text_of(tested);
    vehicle.calm_from_s = 30.0;
    vehicle.calm_share = 0.2;
    const FlightLog calm = vehicle.fly();
    for (const bool exchanged : {false, true}) {
      const Range whole{3.0, 30.0};
      const Range rest{30.0, 44.0};
      const IdentifyResult result =
          identify_axis(about(calm, "roll", declared, exchanged ? rest : whole, exchanged ? whole : rest));
      EXPECT_EQ(result.verdict, "unexplained") << text_of(result);
      EXPECT_EQ(text_of(result).find("saturation is not tested on unseen data") == std::string::npos, exchanged)
          << text_of(result);
    }
  }
}

// Catches a second order that is called untested because it cannot be switched off beside the lead zero that needs it.
TEST(UnseenData, AnEffectThatAnotherNeedsIsTestedWithIt) {
  for (const std::uint64_t seed : {41U, 42U, 43U}) {
    SyntheticAxis vehicle = SyntheticAxis::random(seed);
    vehicle.hidden = {{"lead_zero", 0.2}};
    vehicle.air_rad = 0.002;
    const IdentifyResult result = identify_axis(about(vehicle.fly(), "roll", {"first_order"}));
    EXPECT_EQ(result.verdict, "explained") << text_of(result);
    EXPECT_EQ(effects_beside_trim(result), (std::vector<std::string>{"second_order", "lead_zero"})) << text_of(result);
  }
}

// Catches a clean bill for a model whose number ends at the edge of its range: an axis that follows within 1 ms.
TEST(FinalModel, AParameterAtItsBoundIsSaid) {
  SyntheticAxis vehicle = SyntheticAxis::random(34);
  vehicle.first_order = true;
  vehicle.natural_frequency_rad_s = 1000.0;
  const IdentifyResult result = identify_axis(about(vehicle.fly(), "roll", {"first_order", "transport_delay"}));
  EXPECT_EQ(result.verdict, "unexplained") << text_of(result);
  EXPECT_NE(text_of(result).find("time_constant_s of first_order ends at the edge"), std::string::npos)
      << text_of(result);
}

/// The sticks of a log whose clock runs slower by `rate` than that of the response.
FlightLog with_slow_stick_clock(FlightLog log, double rate) {
  for (const Signal signal : {Signal::kStickRoll, Signal::kStickPitch}) {
    const std::vector<double> stick = log.of(signal);
    for (std::size_t i = 0; i < stick.size(); ++i) {
      const double at = static_cast<double>(i) * (1.0 + rate);
      const auto whole = static_cast<std::size_t>(at);
      log.of(signal)[i] = whole + 1 < stick.size()
                              ? std::round(std::lerp(stick[whole], stick[whole + 1], at - std::floor(at)))
                              : stick.back();
    }
  }
  return log;
}

class StickClockRate : public ::testing::TestWithParam<double> {};

// Catches a clock that drifts and is called a change of the delay: "explained: transport_delay changed at 20.9 s".
TEST_P(StickClockRate, IsNamedAndIsNoChange) {
  const double rate = GetParam();
  for (const std::uint64_t seed : {101U, 102U, 103U}) {
    const FlightLog log = with_slow_stick_clock(SyntheticAxis::random(seed).fly(), rate);
    const std::string text = text_of(identify_axis(about(log, "roll", {"second_order", "transport_delay"})), false);
    EXPECT_TRUE(text.starts_with("unexplained;")) << text;
    EXPECT_EQ(text.find("changed"), std::string::npos) << text;
    EXPECT_EQ(text.find("named"), std::string::npos) << text;
    const std::string lead = "clock_shift: the clock of the sticks runs ";
    const std::size_t at = text.find(lead);
    ASSERT_NE(at, std::string::npos) << text;
    EXPECT_NEAR(std::stod(text.substr(at + lead.size())), 100.0 * std::abs(rate), 0.03 + 10.0 * std::abs(rate)) << text;
    EXPECT_NE(text.find(rate > 0.0 ? "slower" : "faster"), std::string::npos) << text;
  }
}
INSTANTIATE_TEST_SUITE_P(Table, StickClockRate, ::testing::Values(0.001, 0.002, 0.005, 0.01, -0.005));

// A delay that does change is a change, and no clock.
TEST(StickClockRate, IsNotAStepOfTheDelay) {
  for (const std::uint64_t seed : {101U, 102U, 103U}) {
    SyntheticAxis vehicle = SyntheticAxis::random(seed);
    vehicle.change_s = 22.0;
    vehicle.hidden_later = {{"transport_delay", 0.06}};
    const FlightLog log = vehicle.fly();
    const std::string text = text_of(identify_axis(about(log, "roll", {"second_order", "transport_delay"})), false);
    EXPECT_NE(text.find("changed transport_delay at 2"), std::string::npos) << text;
    EXPECT_EQ(text.find("clock"), std::string::npos) << text;
  }
}

/// As a log whose rows are not in step with the samples: each new value begins with a sample between the two.
void read_between_rows(std::vector<double>& stick) {
  const std::vector<double> rows = stick;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    stick[i] = std::lerp(rows[i - 1], rows[i], 0.3);
  }
}

// Catches "the clocks disagree" for a stick that is logged at 10 Hz in rows of 100 Hz.
TEST(HeldStick, ThatTheVehicleDidNotReceiveIsSaid) {
  for (const std::uint64_t seed : {101U, 102U, 103U}) {
    FlightLog log = SyntheticAxis::random(seed).fly();
    std::vector<double>& stick = log.of(Signal::kStickRoll);
    for (std::size_t i = 0; i < stick.size(); ++i) {
      stick[i] = stick[i / 10 * 10];
    }
    if (seed > 101U) {
      read_between_rows(stick);
    }
    const std::string text = text_of(identify_axis(about(log, "roll", {"second_order", "transport_delay"})), false);
    EXPECT_EQ(text.find("unexplained; stick_roll is logged anew every 0.1 s only"), 0U) << text;
    EXPECT_EQ(text.find("clock"), std::string::npos) << text;
    EXPECT_EQ(text.find("named"), std::string::npos) << text;
  }
}

// Catches a clean bill for a stick that is logged in steps so coarse that the response shows what they hide.
TEST(HeldStick, ThatIsRoundedIsSaid) {
  for (const double level : {32.0, 64.0, 128.0}) {
    for (const std::uint64_t seed : {101U, 102U, 103U}) {
      FlightLog log = SyntheticAxis::random(seed).fly();
      for (double& stick : log.of(Signal::kStickRoll)) {
        stick = level * std::round(stick / level);
      }
      if (seed > 101U) {
        read_between_rows(log.of(Signal::kStickRoll));
      }
      const std::string text = text_of(identify_axis(about(log, "roll", {"second_order", "transport_delay"})), false);
      EXPECT_EQ(text.find("unexplained; stick_roll is logged in steps of " + std::to_string(std::lround(level))), 0U)
          << text;
      EXPECT_EQ(text.find("named"), std::string::npos) << text;
    }
  }
}

// A program's commands, on levels and held for a time, are what the vehicle receives.
TEST(HeldStick, ThatTheVehicleReceivedIsSilent) {
  for (const std::uint64_t seed : {101U, 102U, 103U}) {
    SyntheticAxis vehicle = SyntheticAxis::random(seed);
    for (const auto& [counts, samples] : {std::pair{64.0, 1}, std::pair{1.0, 10}, std::pair{64.0, 10}}) {
      vehicle.level_counts = counts;
      vehicle.held_samples = static_cast<std::size_t>(samples);
      const FlightLog log = vehicle.fly();
      const std::string text = text_of(identify_axis(about(log, "roll", {"second_order", "transport_delay"})), false);
      EXPECT_EQ(text, "nothing_missing;");
    }
  }
}

}  // namespace
}  // namespace m100::lab::identify
