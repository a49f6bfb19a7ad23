// SPDX-License-Identifier: BSD-3-Clause
// A pilot who trims in mid-flight: the step must be named however the log is divided, and no air may look like one.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/data/log_ranges.h"
#include "host_tests/property/identify/synthetic_axis.h"
#include "host_tests/unit/identify/one_log.h"

namespace m100::host_tests {
namespace {

using lab::identify::Change;
using lab::identify::IdentifyResult;

/// Air of 0.014 rad; a step of 30 counts is 0.026 rad.
SyntheticAxis in_air(std::uint64_t seed) {
  SyntheticAxis out = SyntheticAxis::random(seed);
  out.air_rad = 0.014;
  out.duration_s = 60.0;
  return out;
}

struct Division {
  const char* name;
  const char* split;  ///< of --split; empty: two thirds train, the rest validates
  std::vector<std::string> declared;
};

IdentifyResult identify(const SyntheticAxis& vehicle, const Division& division) {
  const lab::logs::FlightLog log = vehicle.fly();
  lab::identify::Request request = lab::identify::about(log, "roll", division.declared, {3.0, 40.0}, {40.0, 59.0});
  if (*division.split != '\0') {
    request.train.clear();
    request.validate.clear();
    lab::identify::split(division.split, "3:59", log, request);
  }
  return lab::identify::identify_axis(request);
}

bool is_trim(const Change& change) { return change.name == "trim_offset"; }

class TrimStep : public ::testing::TestWithParam<Division> {};

// Once 7 of 20 such flights had a clean bill with alternate stretches, and 10 of 20 with a declared trim. A step is
// found if it is named, or reported as possible with its time; at most a tenth may be too uncertain for a name.
TEST_P(TrimStep, IsFoundInAir) {
  RecordProperty("promise", "R13");
  constexpr std::uint64_t kLogs = 20;
  int named = 0;
  int found = 0;
  for (std::uint64_t seed = 7701; seed < 7701 + kLogs; ++seed) {
    SyntheticAxis vehicle = in_air(seed);
    vehicle.change_s = 18.0 + static_cast<double>(seed % 20);
    vehicle.hidden_later = {{"trim_offset", seed % 2 == 0 ? 30.0 : -30.0}};
    const IdentifyResult result = identify(vehicle, GetParam());
    EXPECT_NE(result.verdict, "nothing_missing") << seed;
    const bool is_named = std::any_of(result.changes.begin(), result.changes.end(), is_trim);
    const std::string text = lab::identify::text_of(result);
    named += is_named ? 1 : 0;
    found += is_named || text.find("(trim_offset would fit)") != std::string::npos ? 1 : 0;
  }
  EXPECT_GE(found, 19);
  EXPECT_GE(named, 18);
}

TEST_P(TrimStep, IsNotFoundWhereNoneIs) {
  RecordProperty("promise", "R13");
  constexpr std::uint64_t kLogs = 60;
  for (std::uint64_t seed = 8801; seed < 8801 + kLogs; ++seed) {
    const IdentifyResult result = identify(in_air(seed), GetParam());
    const std::string text = lab::identify::text_of(result);
    EXPECT_TRUE(result.changes.empty()) << seed << ": " << text;
    EXPECT_EQ(text.find("may have changed"), std::string::npos) << seed << ": " << text;
  }
}
std::vector<Division> divisions() {
  std::vector<Division> out = {{"Contiguous", "", {"second_order", "transport_delay"}}};
#ifdef M100_EVERY_DIVISION
  out.push_back({"Alternate", "alternate:6", {"second_order", "transport_delay"}});
  out.push_back({"Declared", "alternate:6", {"second_order", "transport_delay", "trim_offset"}});
#endif
  return out;
}
INSTANTIATE_TEST_SUITE_P(Table, TrimStep, ::testing::ValuesIn(divisions()),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace m100::host_tests
