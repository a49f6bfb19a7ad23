// SPDX-License-Identifier: BSD-3-Clause
// A log that holds the same motion twice in different units must not get the verdict "nothing missing", on any axis and
// in either direction. A log whose two signals agree within sensor errors must not be accused.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "host_tests/lab/hidden/hidden_flight.h"
#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/data/unit_consistency.h"
#include "host_tests/property/identify/synthetic_axis.h"
#include "host_tests/unit/identify/one_log.h"

namespace m100::lab::identify {
namespace {

using host_tests::SyntheticAxis;
using logs::FlightLog;
using logs::Signal;

struct SignalUnits {
  const char* name;
  const char* axis;
  Signal stick, response;
  Signal twin;   ///< the derivative or the integral of the response
  bool sums;     ///< the twin is the integral of the response
  double scale;  ///< factor of the response to a usual size
  double noise;  ///< of the twin
};

const std::vector<SignalUnits>& voices() {
  static const std::vector<SignalUnits> kVoices{
      {"roll", "roll", Signal::kStickRoll, Signal::kAttitudeRoll, Signal::kRateX, false, 1.0, 0.05},
      {"pitch", "pitch", Signal::kStickPitch, Signal::kAttitudePitch, Signal::kRateY, false, 1.0, 0.05},
      {"yaw", "yaw_rate", Signal::kStickYaw, Signal::kRateZ, Signal::kAttitudeYaw, true, -2.0, 0.01},
      {"climb", "climb", Signal::kStickThrottle, Signal::kVelocityZ, Signal::kPositionZ, true, 4.0, 0.02}};
  return kVoices;
}

/// One axis and the signal of another sensor for the same motion.
FlightLog two_voices(const SignalUnits& voice, std::uint64_t seed) {
  SyntheticAxis vehicle = SyntheticAxis::random(seed);
  FlightLog log = vehicle.fly();
  const std::vector<double> stick = log.of(Signal::kStickRoll);
  const std::vector<double> response = log.of(Signal::kAttitudeRoll);
  for (const Signal signal : {Signal::kStickRoll, Signal::kStickPitch, Signal::kAttitudeRoll}) {
    log.of(signal).clear();
  }
  log.of(voice.stick) = stick;
  log.of(voice.response) = response;
  std::vector<double>& twin = log.of(voice.twin);
  twin.assign(log.size, 0.0);
  std::mt19937_64 random(seed + 99);
  std::normal_distribution<double> normal;
  double sum = 0.0;
  for (std::size_t k = 0; k < log.size; ++k) {
    log.of(voice.response)[k] *= voice.scale;
    sum += voice.scale * response[k] * log.period_s;
    const std::size_t from = k > 2 ? k - 2 : 0;
    const std::size_t to = std::min(k + 2, log.size - 1);
    const double slope =
        voice.scale * (response[to] - response[from]) / (static_cast<double>(to - from) * log.period_s);
    twin[k] = (voice.sums ? sum : slope) + voice.noise * normal(random);
  }
  return log;
}

IdentifyResult ask(const FlightLog& log, const std::string& axis) {
  return identify_axis(about(log, axis, {"second_order", "transport_delay"}));
}

class TwoSignals : public ::testing::TestWithParam<SignalUnits> {};

TEST_P(TwoSignals, AreAcceptedWhereTheyAgree) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_TRUE(unit_contradictions(two_voices(GetParam(), seed), GetParam().axis, {}).empty()) << "seed " << seed;
  }
}

TEST_P(TwoSignals, ContradictEachOtherInEveryUnitInUse) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const bool angle = std::string(GetParam().axis) != "climb";
  const std::vector<double> factors = angle ? std::vector{kDegrees, 1.0 / kDegrees}
                                            : std::vector{100.0, 0.01, 1.0 / 0.3048, 0.3048, 1.944, 0.514, 3.6, 0.278};
  for (const double factor : factors) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      FlightLog log = two_voices(GetParam(), seed);
      for (double& value : log.of(GetParam().response)) {
        value *= factor;
      }
      const std::vector<Finding> found = unit_contradictions(log, GetParam().axis, {});
      ASSERT_EQ(found.size(), 1U) << "factor " << factor << " seed " << seed;
      EXPECT_EQ(found[0].what, "wrong_unit");
    }
  }
}

// Runs the whole identification with a response too small to be noticed by its size.
TEST_P(TwoSignals, InTwoUnitsAreReported) {
  FlightLog log = two_voices(GetParam(), 3);
  for (double& value : log.of(GetParam().response)) {
    value *= 0.3048;
  }
  EXPECT_EQ(ask(log, GetParam().axis).verdict, "unexplained");
}

// Catches a test that takes the noise of one sensor for a factor: signals with little in common give no evidence.
TEST_P(TwoSignals, SayNothingWhereOneIsNoise) {
  FlightLog log = two_voices(GetParam(), 4);
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (double& value : log.of(GetParam().twin)) {
    value += 50.0 * normal(random);
  }
  EXPECT_TRUE(unit_contradictions(log, GetParam().axis, {}).empty());
}

INSTANTIATE_TEST_SUITE_P(Table, TwoSignals, ::testing::ValuesIn(voices()),
                         [](const auto& tested) { return std::string(tested.param.name); });

// Without height and accelerometer only the sign of the thrust reveals centimetres: no rotor pushes down.
TEST(ClimbAlone, NoRotorPushesDown) {
  FlightLog log = two_voices(voices()[3], 5);
  log.of(Signal::kPositionZ).clear();
  EXPECT_TRUE(unit_contradictions(log, "climb", {}).empty());
  for (double& value : log.of(Signal::kVelocityZ)) {
    value *= 100.0;
  }
  EXPECT_EQ(unit_contradictions(log, "climb", {}).size(), 1U);
}

TEST(Translation, VelocityIsTheSlopeOfPosition) {
  FlightLog log = hidden::fly({.axis = "translation", .hidden = {}, .seed = 11});
  EXPECT_TRUE(unit_contradictions(log, "translation", {}).empty());
  for (double& value : log.of(Signal::kVelocityX)) {
    value *= 100.0;
  }
  const std::vector<Finding> found = unit_contradictions(log, "translation", {{5.0, 40.0}});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].signal, "position_x");
}

}  // namespace
}  // namespace m100::lab::identify
