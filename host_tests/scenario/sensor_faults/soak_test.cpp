// SPDX-License-Identifier: BSD-3-Clause
// Every lie of every channel, in calm air and in wind, in a hover and before control is taken. For the nightly run.
#include <gtest/gtest.h>

#include "host_tests/scenario/sensor_faults/sensor_fault_bench.h"

namespace m100::scenario {
namespace {

constexpr int kSeeds = 5;
/// Limit of the distance. The largest observed one is 4.4 m, by a drift that begins before the first pose and cannot be
/// observed until the course ends.
constexpr double kRoom_m = 6.0;

class EverySensorFault : public ::testing::TestWithParam<sim::SensorFault> {};

TEST_P(EverySensorFault, IsFlownInCalmAirAndInWindBeforeAndAfterControlIsTaken) {
  RecordProperty("promise", "R14");
  const sim::SensorFault& fault = GetParam();
  std::string row;
  for (const double from_s : {kFaultAt_s, kFromStart}) {
    for (const Air air : {Air::kCalm, Air::kWind}) {
      Worst worst;
      for (int seed = 1; seed <= kSeeds; ++seed) {
        worst.note(detected({.fault = &fault, .size = fault.size, .from_s = from_s, .air = air}, seed));
      }
      EXPECT_LE(worst.of.away_m, kRoom_m);
      EXPECT_LE(worst.of.farthest_m, kRoom_m);
      row += (row.empty() ? "" : " | ") + worst.cell();
    }
  }
  RecordProperty("figure.every." + std::string(fault.name), row);
  std::printf("%s | %s\n", std::string(fault.name).c_str(), row.c_str());
}
INSTANTIATE_TEST_SUITE_P(SensorFaults, EverySensorFault,
                         ::testing::ValuesIn(sim::sensor_faults().begin(), sim::sensor_faults().end()),
                         [](const auto& tested) { return std::string(tested.param.name); });

const SizedFault kSizedFaults[] = {
    {"tilt_times", "tilt_times", "hover", 1.05, 57.0},     {"tilt_offset", "tilt_offset", "hover", 0.5, 45.0},
    {"rates_times", "rates_times", "hover", 1.05, 57.0},   {"telemetry_late", "telemetry_late", "hover", 10.0, 400.0},
    {"younger", "younger", "step_3m", 10.0, 400.0},        {"repeated", "repeated", "hover", 0.02, 1.0},
    {"force_offset", "force_offset", "hover", 0.05, 10.0}, {"yaw", "yaw", "hover", 1.0, 90.0},
};

class SmallestFault : public ::testing::TestWithParam<SizedFault> {};

TEST_P(SmallestFault, ThatIsNoticedWithEverySeed) {
  RecordProperty("promise", "R14");
  const SizedFault& sized = GetParam();
  const std::string found = smallest_detected(sized, kSeeds);
  char none[64];
  static_cast<void>(std::snprintf(none, sizeof none, "none up to %.3g %s | - | - | -", sized.large,
                                  sim::find_sensor_fault(sized.fault)->unit.data()));
  const std::string row = found == "none" ? none : found;
  RecordProperty("figure.least." + std::string(sized.name), row);
  std::printf("smallest %s | %s\n", sized.name, row.c_str());
}
INSTANTIATE_TEST_SUITE_P(SensorFaults, SmallestFault, ::testing::ValuesIn(kSizedFaults),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace m100::scenario
