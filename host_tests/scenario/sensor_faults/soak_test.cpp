// SPDX-License-Identifier: BSD-3-Clause
// Every sensor fault of every channel, in calm air and in wind, in a hover and before control is taken. Nightly.
#include <gtest/gtest.h>

#include "host_tests/scenario/sensor_faults/sensor_fault_bench.h"

namespace m100::scenario {
namespace {

constexpr int kSeeds = 5;
/// Limit of the distance. The largest measured is 4.4 m: a drift from before the first pose, which nothing contradicts.
constexpr double kRoom_m = 6.0;

class EverySensorFault : public ::testing::TestWithParam<sim::SensorFault> {};

TEST_P(EverySensorFault, IsFlownInCalmAirAndInWindBeforeAndAfterControlIsTaken) {
  RecordProperty("promise", "R14");
  const sim::SensorFault& fault = GetParam();
  const std::string size = fault.unit.empty() ? "" : printed(", %g ", fault.size) + std::string(fault.unit);
  std::string row = "`" + std::string(fault.name) + "`: " + std::string(fault.words) + size;
  for (const double from_s : {kFaultAt_s, kFromStart}) {
    for (const Air air : {Air::kCalm, Air::kWind}) {
      Worst worst;
      for (int seed = 1; seed <= kSeeds; ++seed) {
        worst.note(detected({.fault = &fault, .size = fault.size, .from_s = from_s, .air = air}, seed));
      }
      EXPECT_LE(worst.of.away_m, kRoom_m);
      EXPECT_LE(worst.of.farthest_m, kRoom_m);
      row += " | " + worst.cell();
    }
  }
  RecordProperty("figure.every." + std::string(fault.name), row);
  std::printf("%s\n", row.c_str());
}
INSTANTIATE_TEST_SUITE_P(SensorFaults, EverySensorFault,
                         ::testing::ValuesIn(sim::sensor_faults().begin(), sim::sensor_faults().end()),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace m100::scenario
