// SPDX-License-Identifier: BSD-3-Clause
// identify_coverage [--logs N] [--seed S] [--json FILE] [--judge 1] [--flights hand|excited] [--verbose 1]: how often
// the 95 % intervals of identify contain the true value, over simulated logs of a hand, or over the excited flights of
// simulated evenings. With --judge, exit code 1: a parameter is outside the limits of coverage_limits.h.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/hidden/effect_sizes.h"
#include "host_tests/lab/hidden/hidden_flight.h"
#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/data/log_ranges.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/translation_pipeline.h"
#include "host_tests/property/identify/coverage_limits.h"
#include "host_tests/property/identify/excited_flight.h"
#include "host_tests/property/identify/synthetic_axis.h"
#include "host_tests/unit/identify/one_log.h"

namespace {

namespace lab = m100::lab;
using m100::Json;
using m100::host_tests::SyntheticAxis;
using Truth = std::map<std::string, double>;

/// One log and its true parameters. Ten blocks of 2.5 s are fitted.
struct Known {
  lab::logs::FlightLog log;
  std::string axis;
  std::vector<std::string> declared;
  Truth truth;  ///< by the names of the final model's parameters
};

Known roll(std::uint64_t seed) {
  SyntheticAxis vehicle = SyntheticAxis::random(seed);
  const double width = SyntheticAxis::random_size("dead_zone", 1, seed);
  const double trim = SyntheticAxis::random_size("trim_offset", 1, seed + 1);
  vehicle.hidden = {{"dead_zone", width}, {"trim_offset", trim}};
  return {vehicle.fly(),
          "roll",
          {"second_order", "transport_delay", "dead_zone", "trim_offset"},
          {{"gain", vehicle.gain_rad},
           {"natural_frequency_rad_s", vehicle.natural_frequency_rad_s},
           {"damping_ratio", vehicle.damping_ratio},
           {"delay_s", vehicle.delay_s},
           {"width_counts", width},
           {"offset_counts", trim}}};
}

Known translation(std::uint64_t seed) {
  lab::hidden::FlightPlan plan;
  plan.axis = "translation";
  plan.seed = seed;
  const bool of_body = seed % 2 == 1;
  if (of_body) {
    const double drag = lab::hidden::size_of("body_drag", 1, seed);
    plan.hidden = {{"body_drag", drag}};
    return {
        lab::hidden::fly(plan), plan.axis, {"rigid_body", "body_drag"}, {{"x_per_s", 0.3 * drag}, {"y_per_s", drag}}};
  }
  const double drag = lab::hidden::size_of("linear_drag", 1, seed);
  const double gain = lab::hidden::size_of("tilt_gain", 1, seed);
  plan.hidden = {{"linear_drag", drag}, {"tilt_gain", gain}};
  return {lab::hidden::fly(plan),
          plan.axis,
          {"rigid_body", "linear_drag", "tilt_gain"},
          {{"rate_per_s", drag}, {"tilt_gain", gain}}};
}

using Counts = std::map<std::string, m100::host_tests::Coverage>;

void print_answer(std::uint64_t seed, const m100::host_tests::ExcitedAxis& axis,
                  const lab::identify::IdentifyResult& result) {
  std::printf("%llu %s %s %.2f s:", static_cast<unsigned long long>(seed), axis.name.c_str(), result.verdict.c_str(),
              result.elapsed_s);
  for (const std::string& name : result.final_model.structure) {
    std::printf(" %s", name.c_str());
  }
  for (const lab::identify::NamedInterval& one : result.final_intervals) {
    const auto truth = axis.truth.find(one.name);
    const bool known = truth != axis.truth.end();
    const bool outside = known && (truth->second < one.interval.low || truth->second > one.interval.high);
    std::printf("\n    %s%s %.5g [%.5g, %.5g] truly %.5g", outside ? "MISSED " : "", one.name.c_str(),
                one.interval.value, one.interval.low, one.interval.high, known ? truth->second : 0.0);
  }
  for (const lab::identify::Change& change : result.changes) {
    std::printf("\n    CHANGE %s at %.1f s, ratio %.1f", change.name.c_str(), change.at_s, change.likelihood_ratio);
  }
  for (const std::string& left : result.unexplained) {
    std::printf("\n    unexplained: %s", left.c_str());
  }
  std::printf("\n");
  std::fflush(stdout);
}

void count_intervals(const std::string& axis, const Truth& truth, const lab::identify::IdentifyResult& result,
                     Counts& counts) {
  for (const lab::identify::NamedInterval& one : result.final_intervals) {
    const auto found = truth.find(one.name);
    if (found == truth.end()) {
      continue;
    }
    m100::host_tests::Coverage& count = counts[axis + " " + one.name];
    ++count.answered;
    count.covered += one.interval.low <= found->second && found->second <= one.interval.high ? 1 : 0;
    count.relative_error += (one.interval.value - found->second) / std::abs(found->second);
    count.relative_width += 0.5 * (one.interval.high - one.interval.low) / std::abs(found->second);
  }
}

/// @returns false if the answer has another structure than the true one, and so intervals of other parameters.
bool ask(const Known& known, Counts& counts) {
  for (const auto& [name, truth] : known.truth) {
    ++counts[known.axis + " " + name].asked;
  }
  auto request = lab::identify::about(known.log, known.axis, known.declared, {3.0, 28.0}, {28.0, 44.0});
  request.refits = lab::identify::Request{}.refits;
  const lab::identify::IdentifyResult result = known.axis == "translation"
                                                   ? lab::identify::identify_translation(request)
                                                   : lab::identify::identify_axis(request);
  if (result.final_model.structure != known.declared || !result.changes.empty()) {
    return false;
  }
  count_intervals(known.axis, known.truth, result, counts);
  return true;
}

/// The axes of one excited flight, with what an evening declares and its split.
/// @returns the number of axes that were answered with a change.
int ask_excited(std::uint64_t seed, bool rates, bool verbose, Counts& counts) {
  const m100::host_tests::ExcitedFlight flight = m100::host_tests::fly_excited(seed, rates);
  if (!flight.is_over) {
    std::printf("seed %llu: the movements were aborted\n", static_cast<unsigned long long>(seed));
    return 0;
  }
  int changes = 0;
  for (const m100::host_tests::ExcitedAxis& axis : m100::host_tests::axes_of(flight, rates)) {
    lab::identify::Request request;
    request.axis = axis.name;
    request.declared = axis.declared;
    request.log = request.validation_log = &flight.log;
    lab::identify::split("alternate:6",
                         std::to_string(axis.within_s.first) + ":" + std::to_string(axis.within_s.second), flight.log,
                         request);
    const lab::identify::IdentifyResult result = lab::identify::identify_axis(request);
    for (const auto& [name, truth] : axis.truth) {
      ++counts[axis.name + " " + name].asked;
    }
    count_intervals(axis.name, axis.truth, result, counts);
    changes += result.changes.empty() ? 0 : 1;
    if (verbose) {
      print_answer(seed, axis, result);
    }
  }
  return changes;
}

/// @returns 1 if a parameter is not as stated.
int report(const Counts& counts, int others, const std::string& file) {
  Json rows = Json::array();
  std::printf("%-36s %6s %10s %16s %12s\n", "parameter (simulated)", "logs", "covered", "mean half width",
              "mean error");
  for (const auto& [name, count] : counts) {
    const double percent = 100.0 * count.covered / std::max(1, count.answered);
    const double width = 100.0 * count.relative_width / std::max(1, count.answered);
    const double error = 100.0 * count.relative_error / std::max(1, count.answered);
    std::printf("%-36s %6d %8.1f %% %14.1f %% %10.2f %%\n", name.c_str(), count.answered, percent, width, error);
    rows.push_back({{"parameter", name},
                    {"logs", count.answered},
                    {"covered_percent", percent},
                    {"half_width_percent", width},
                    {"error_percent", error}});
  }
  std::printf("%d logs were answered with another structure and are left out\n", others);
  if (!file.empty()) {
    std::ofstream(file) << Json{{"parameters", rows}, {"other_structure", others}}.dump(1) << "\n";
  }
  const std::vector<std::string> offences = m100::host_tests::outside_limits(counts);
  for (const std::string& offence : offences) {
    std::printf("OUTSIDE THE GOAL: %s\n", offence.c_str());
  }
  return offences.empty() ? 0 : 1;
}

/// @returns the number of logs of this seed that were refused, or answered with another structure.
int others_of(std::uint64_t number, Counts& counts) {
  int others = 0;
  for (const Known& known : {roll(number), translation(2 * number), translation(2 * number + 1)}) {
    try {
      others += ask(known, counts) ? 0 : 1;
    } catch (const std::exception& refused) {
      std::printf("%s, seed %llu: %s\n", known.axis.c_str(), static_cast<unsigned long long>(number), refused.what());
      ++others;
    }
  }
  return others;
}

/// The value of an option, or what counts without it.
std::string value_of(const std::vector<std::string>& given, const std::string& option, const std::string& otherwise) {
  const auto at = std::find(given.begin(), given.end(), option);
  return given.end() - at < 2 ? otherwise : at[1];
}

}  // namespace

int main(int count, char** words) {  // NOLINT(bugprone-exception-escape): only out of memory, which ends it as well
  const std::vector<std::string> given(words + 1, words + count);
  const int logs = std::atoi(value_of(given, "--logs", "500").c_str());
  const std::uint64_t seed = std::strtoull(value_of(given, "--seed", "1").c_str(), nullptr, 10);
  const std::string file = value_of(given, "--json", "");
  const bool judge = !value_of(given, "--judge", "").empty();
  const bool excited = value_of(given, "--flights", "") == "excited";
  const bool verbose = !value_of(given, "--verbose", "").empty();
  Counts counts;
  int others = 0;
  int changes = 0;
  for (int k = 0; k < logs; ++k) {
    const std::uint64_t number = seed + static_cast<std::uint64_t>(k);
    if (excited) {
      changes += ask_excited(number, false, verbose, counts) + ask_excited(number, true, verbose, counts);
    } else {
      others += others_of(number, counts);
    }
  }
  if (excited) {
    std::printf("%d of %d axes were answered with a change that is not there\n", changes, 4 * logs);
  }
  const int outside = report(counts, others, file);
  return judge ? outside : 0;
}
