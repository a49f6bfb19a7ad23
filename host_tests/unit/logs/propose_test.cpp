// SPDX-License-Identifier: BSD-3-Clause
// Column maps that are proposed for recognised logs: they must load, and say what is known of the flights.
#include "host_tests/lab/logs/propose.h"

#include <cmath>

#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/shared_files.h"
#include "host_tests/unit/logs/log_files.h"

namespace m100::lab::logs {
namespace {

struct Known {
  const char* name;
  const char* file;
  const char* dialect;
  std::vector<Signal> has;
};
class KnownLog : public ::testing::TestWithParam<Known> {};

TEST_P(KnownLog, IsRecognisedAndItsMapLoads) {
  M100_SHARED_FILE_OR_SKIP(path, std::string("data/") + GetParam().file);
  const auto raw = open_log(path.string());
  const auto proposal = propose(*raw);
  ASSERT_TRUE(proposal);
  EXPECT_EQ(proposal->dialect, GetParam().dialect);
  const FlightLog log = load(*raw, parse_column_map(proposal->toml, "proposed"));
  for (const Signal signal : GetParam().has) {
    EXPECT_TRUE(log.has(signal)) << name_of(signal) << "\n" << proposal->toml;
  }
  EXPECT_FALSE(raw->topics().empty());
}

INSTANTIATE_TEST_SUITE_P(
    Shared, KnownLog,
    ::testing::Values(Known{"Px4Of2017",
                            "px4/sample.ulg",
                            "PX4",
                            {Signal::kAttitudeRoll, Signal::kCommandRoll, Signal::kRateX, Signal::kForceZ,
                             Signal::kVelocityX}},
                      Known{"Px4Small", "px4/sample_log_small.ulg", "PX4", {Signal::kAttitudeRoll, Signal::kRateX}},
                      Known{"Px4Appended", "px4/sample_appended_multiple.ulg", "PX4", {Signal::kAttitudeRoll}},
                      Known{"ArduPilot",
                            "formats/tiny.bin",
                            "ArduPilot",
                            {Signal::kAttitudeRoll, Signal::kCommandRoll, Signal::kVelocityX, Signal::kPositionZ}},
                      Known{"DjiBag", "formats/bag_humble.db3", "a DJI bag", {Signal::kAttitudeRoll, Signal::kRateX}},
                      Known{"PublishedMat",
                            "m100/ExperimentPitchRoll.mat",
                            "the published MAT-files",
                            {Signal::kAttitudeRoll, Signal::kStickRoll, Signal::kRateX}},
                      Known{"MeasuredCsv",
                            "m100/pitch_roll.csv",
                            "the measured flights as CSV",
                            {Signal::kAttitudeRoll, Signal::kStickRoll, Signal::kRateX}},
                      Known{"BlindExample",
                            "blind_examples/log_00.csv",
                            "the measured flights as CSV",
                            {Signal::kAttitudeRoll, Signal::kStickRoll, Signal::kPositionX, Signal::kForceZ}}),
    [](const auto& tested) { return tested.param.name; });

TEST(Propose, SaysNothingOfNamesThatItDoesNotKnow) {
  const TemporaryFile file("a.csv", "a,b\n0,1\n1,2\n");
  EXPECT_FALSE(propose(*open_log(file.path())));
}

}  // namespace
}  // namespace m100::lab::logs
