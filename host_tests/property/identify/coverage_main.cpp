// SPDX-License-Identifier: BSD-3-Clause
// identify_coverage [--logs N] [--seed S] [--json FILE] [--judge 1]: how often the 95 % intervals of identify contain
// the true value, over simulated logs. With --judge, exit code 1: a parameter is not as coverage_limits.h states.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host_tests/lab/hidden/effect_sizes.h"
#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/translation_pipeline.h"
#include "host_tests/oracle/hidden_flight.h"
#include "host_tests/oracle/synthetic_axis.h"
#include "host_tests/property/identify/coverage_limits.h"

namespace {

namespace lab = m100::lab;
namespace oracle = m100::oracle;
using m100::oracle::SyntheticAxis;
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
  oracle::FlightPlan plan;
  plan.axis = "translation";
  plan.seed = seed;
  const bool of_body = seed % 2 == 1;
  if (of_body) {
    const double drag = lab::hidden::size_of("body_drag", 1, seed);
    plan.hidden = {{"body_drag", drag}};
    return {oracle::fly(plan), plan.axis, {"rigid_body", "body_drag"}, {{"x_per_s", 0.3 * drag}, {"y_per_s", drag}}};
  }
  const double drag = lab::hidden::size_of("linear_drag", 1, seed);
  const double gain = lab::hidden::size_of("tilt_gain", 1, seed);
  plan.hidden = {{"linear_drag", drag}, {"tilt_gain", gain}};
  return {oracle::fly(plan),
          plan.axis,
          {"rigid_body", "linear_drag", "tilt_gain"},
          {{"rate_per_s", drag}, {"tilt_gain", gain}}};
}

using Counts = std::map<std::string, m100::host_tests::Coverage>;

/// @returns false if the answer has another structure than the true one, and so intervals of other parameters.
bool ask(const Known& known, Counts& counts) {
  for (const auto& [name, truth] : known.truth) {
    ++counts[known.axis + " " + name].asked;
  }
  lab::identify::Request request;
  request.axis = known.axis;
  request.declared = known.declared;
  request.train = {{3.0, 28.0}};
  request.validate = {{28.0, 44.0}};
  request.log = request.validation_log = &known.log;
  const lab::identify::IdentifyResult result = known.axis == "translation"
                                                   ? lab::identify::identify_translation(request)
                                                   : lab::identify::identify_axis(request);
  if (result.final_model.structure != known.declared || !result.changes.empty()) {
    return false;
  }
  for (const lab::identify::NamedInterval& one : result.final_intervals) {
    const auto found = known.truth.find(one.name);
    if (found == known.truth.end()) {
      continue;
    }
    m100::host_tests::Coverage& count = counts[known.axis + " " + one.name];
    ++count.answered;
    count.covered += one.interval.low <= found->second && found->second <= one.interval.high ? 1 : 0;
    count.relative_error += (one.interval.value - found->second) / std::abs(found->second);
    count.relative_width += 0.5 * (one.interval.high - one.interval.low) / std::abs(found->second);
  }
  return true;
}

/// @returns 1 if a parameter is not as stated.
int report(const Counts& counts, int others, const std::string& file) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
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
    std::ofstream(file) << nlohmann::ordered_json{{"parameters", rows}, {"other_structure", others}}.dump(1) << "\n";
  }
  const std::vector<std::string> offences = m100::host_tests::not_as_stated(counts);
  for (const std::string& offence : offences) {
    std::printf("NOT AS STATED: %s\n", offence.c_str());
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

}  // namespace

int main(int count, char** words) {  // NOLINT(bugprone-exception-escape): only out of memory, which ends it as well
  int logs = 500;
  std::uint64_t seed = 1;
  std::string file;
  bool judge = false;
  const std::vector<std::string> given(words + 1, words + count);
  for (std::size_t k = 0; k + 1 < given.size(); k += 2) {
    logs = given[k] == "--logs" ? std::atoi(given[k + 1].c_str()) : logs;
    seed = given[k] == "--seed" ? std::strtoull(given[k + 1].c_str(), nullptr, 10) : seed;
    file = given[k] == "--json" ? given[k + 1] : file;
    judge = judge || given[k] == "--judge";
  }
  Counts counts;
  int others = 0;
  for (int k = 0; k < logs; ++k) {
    others += others_of(seed + static_cast<std::uint64_t>(k), counts);
  }
  const int outside = report(counts, others, file);
  return judge ? outside : 0;
}
