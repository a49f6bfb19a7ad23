// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "firmware/model/stick_axis.h"
#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/inject/inject.h"
#include "host_tests/lab/statistics.h"
#include "host_tests/shared_files.h"
#include "host_tests/unit/identify/one_log.h"

namespace m100::lab::hidden {
namespace {

using identify::IdentifyResult;
using Names = std::vector<std::string>;

logs::FlightLog measured_flight(const std::string& csv) {
  return logs::load(csv, "host_tests/lab/columns/m100_csv.toml");
}

IdentifyResult analyse(const logs::FlightLog& log, const std::string& axis, const Names& declared) {
  return identify::identify_axis(identify::about(log, axis, declared, {12.0, 38.0}, {38.0, 55.5}));
}

Names found_in(const IdentifyResult& result) {
  Names out;
  for (const auto& effect : result.effects) {
    out.push_back(effect.name);
  }
  return out;
}

bool has(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

double delay_in(const IdentifyResult& result) {
  for (const auto& parameter : result.final_model.parameters) {
    if (parameter.name == "delay_s") {
      return parameter.value;
    }
  }
  return 0.0;
}

// Regression test: with a curve and an asymmetry, up to 1.7 times the effect was added.
TEST(Injection, AddsAsMuchAsItSays) {
  const model::StickAxis own{.scale_per_count = 0.005,
                             .dead_zone_counts = 30.0,
                             .dead_zone_shape = model::DeadZoneShape::kJump,
                             .gain_asymmetry = 1.37,
                             .trim_counts = -5.0,
                             .stick_exponent = 1.53};
  model::StickAxis with = own;
  with.trim_counts += 40.0;
  for (const double stick : {200.0, -200.0}) {
    logs::FlightLog log;
    log.size = 600;
    log.of(logs::Signal::kStickThrottle).assign(log.size, stick);
    log.of(logs::Signal::kVelocityZ).assign(log.size, 0.0);
    identify::ModelResult fitted;
    fitted.dead_zone_shape = "jump";
    fitted.parameters = {{"gain", 0.005},    {"time_constant_s", 0.2}, {"ratio", 1.37},
                         {"exponent", 1.53}, {"offset_counts", -5.0},  {"width_counts", 30.0}};
    const double added = inject(log, "climb", fitted, {{"trim_offset", 40.0}}).of(logs::Signal::kVelocityZ).back();
    const double wanted = model::StickLaw<double>(with, log.period_s).shaped(stick) -
                          model::StickLaw<double>(own, log.period_s).shaped(stick);
    EXPECT_NEAR(added, wanted, 1e-6 * std::abs(wanted));
    EXPECT_THROW(inject(log, "climb", fitted, {{"trim_offsets", 40.0}}), std::exception) << "added nothing";
  }
}

// Regression test: with a lead zero declared, the fit without the trim ended at the edge of the range (a zero of 1 s, a
// dead zone of 55 counts), the fit with the trim started there, and 40 counts of trim stayed "unexplained".
TEST(Injection, AFitThatEndedAtAnEdgeIsNoStartForWhatIsMissing) {
  M100_SHARED_FILE_OR_SKIP(csv, "data/m100/pitch_roll.csv");
  const logs::FlightLog flight = measured_flight(csv.string());
  const Names declared{"second_order", "dead_zone", "lead_zero"};
  const IdentifyResult plain = analyse(flight, "roll", declared);
  const IdentifyResult result =
      analyse(inject(flight, "roll", plain.declared, {{"trim_offset", 40.0}}), "roll", declared);
  EXPECT_TRUE(has(found_in(result), "trim_offset")) << result.verdict;
}

struct Case {
  HiddenEffects hidden;
  Names allowed;
};

/// All effects at medium size, for this axis of the flight.
std::vector<Case> medium_effects(const logs::FlightLog& flight, const std::string& axis) {
  const auto& y = flight.of(axis == "roll" ? logs::Signal::kAttitudeRoll : logs::Signal::kAttitudePitch);
  std::vector<double> rate(y.size(), 0.0);
  for (std::size_t k = 1; k < y.size(); ++k) {
    rate[k] = (y[k] - y[k - 1]) / flight.period_s;
  }
  return {{{{"transport_delay", 0.1}}, {"transport_delay", "lead_zero"}},
          {{{"saturation", 0.7 * lab::large(y)}}, {"saturation", "tilt_limit"}},
          {{{"rate_limit", 0.5 * lab::large(rate)}}, {"rate_limit"}},
          {{{"gain_asymmetry", 1.25}}, {"gain_asymmetry"}},
          {{{"gain_asymmetry", 0.8}}, {"gain_asymmetry"}},
          {{{"trim_offset", 40.0}}, {"trim_offset"}},
          {{{"stick_curve", 1.35}}, {"stick_curve"}},
          {{{"backlash", 18.0}}, {"backlash"}},
          {{{"gain_drift", -0.28}}, {"gain_drift"}},
          {{{"cross_axis", 0.17}}, {"cross_axis"}}};
}

/// Whether `result` names the added effect and, if the flight already has some of it, the parameter shows the addition.
bool is_named(const Case& added, const IdentifyResult& plain, const IdentifyResult& result) {
  const Names found = found_in(result);
  if (std::none_of(added.allowed.begin(), added.allowed.end(), [&](const auto& name) { return has(found, name); })) {
    return false;
  }
  // The flight has its own delay with a lead zero; the parameter must show the added delay.
  return added.hidden.count("transport_delay") == 0 ||
         delay_in(result) > delay_in(plain) + 0.6 * added.hidden.at("transport_delay");
}

// Adds effects to the real flight and keeps its measured residual, with air and autopilot. Goal: 90 % at medium size.
TEST(Injection, IntoTheMeasuredFlightIsNamed) {
  RecordProperty("promise", "R13");
  M100_SHARED_FILE_OR_SKIP(csv, "data/m100/pitch_roll.csv");
  const logs::FlightLog flight = measured_flight(csv.string());
  int right = 0;
  int count = 0;
  for (const std::string axis : {"roll", "pitch"}) {
    const Names declared{"second_order", "dead_zone"};
    const IdentifyResult plain = analyse(flight, axis, declared);
    // Every model has a trim, and the flight has some of its own: the addition may carry it over the 3 counts of a
    // name.
    Names before = found_in(plain);
    before.emplace_back("trim_offset");
    for (const Case& added : medium_effects(flight, axis)) {
      const IdentifyResult result = analyse(inject(flight, axis, plain.declared, added.hidden), axis, declared);
      const Names found = found_in(result);
      const bool named = is_named(added, plain, result);
      const bool nothing_else = std::all_of(
          found.begin(), found.end(), [&](const auto& name) { return has(added.allowed, name) || has(before, name); });
      ++count;
      right += named && nothing_else ? 1 : 0;
      if (named) {
        EXPECT_LT(result.final_model.validation_rmse, result.declared.validation_rmse) << added.hidden.begin()->first;
      }
    }
  }
  RecordProperty("figure.injection", std::to_string(right) + " of " + std::to_string(count));
  EXPECT_GE(10 * right, 9 * count) << right << " of " << count;
}

}  // namespace
}  // namespace m100::lab::hidden
