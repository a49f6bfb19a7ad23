// SPDX-License-Identifier: BSD-3-Clause
// What looks like a defect of a log and is none: pulses of a machine, a rounded signal that rests and starts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host_tests/lab/identify/log_defects.h"

namespace m100::lab::identify {
namespace {

constexpr double kPeriod_s = 0.01;
constexpr std::size_t kSamples = 6000;

/// Pulses of 0.3 to 1.8 s to either side.
std::vector<double> pulses() {
  std::vector<double> out(kSamples);
  double value = 120.0;
  std::size_t until = 60;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (i >= until) {
      value = -value;
      until = i + 30 + (i * 37) % 150;
    }
    out[i] = value;
  }
  return out;
}

/// A hand's slow swings, cut where the log's range ends.
std::vector<double> cut_hand() {
  std::vector<double> out(kSamples);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double t_s = kPeriod_s * static_cast<double>(i);
    out[i] = std::clamp(200.0 * std::sin(2.1 * t_s) + 120.0 * std::sin(5.3 * t_s + 1.0), -120.0, 120.0);
  }
  return out;
}

// Catches a log of pulses, the oldest excitation there is, that is refused for standing at its stops.
TEST(CutShare, IsThatOfAHandAndNotOfPulses) {
  const std::vector<char> used(kSamples, 1);
  const Clock clock{0.0, kPeriod_s, kPeriod_s};
  EXPECT_EQ(cut_share(pulses(), used, clock), 0.0);
  EXPECT_GT(cut_share(cut_hand(), used, clock), 0.2);
}

// Rows every 0.1 s do not tell the two apart: then the doubt stays.
TEST(CutShare, StaysInDoubtWhereRowsAreSlow) {
  const std::vector<char> used(kSamples, 1);
  EXPECT_GT(cut_share(pulses(), used, {0.0, kPeriod_s, 0.1}), 0.9);
}

/// A climb speed rounded to 0.01 m/s: it rests on one step for two seconds, then follows a pulse of the stick.
std::vector<double> rounded_steps() {
  std::vector<double> out(kSamples);
  double speed = 0.0;
  double rate = 0.0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double wanted = (i / 200) % 2 == 0 ? 0.0 : ((i / 400) % 2 == 0 ? 0.35 : -0.3);
    constexpr double kFrequency_rad_s = 11.0;
    rate += kPeriod_s * (kFrequency_rad_s * kFrequency_rad_s * (wanted - speed) - 1.6 * kFrequency_rad_s * rate);
    speed += kPeriod_s * rate;
    out[i] = 0.01 * std::round(100.0 * speed);
  }
  return out;
}

// Catches a rest that is called frozen because the signal is counted in steps and then starts.
TEST(RoundedSignal, RestsAndStartsWithoutBeingFrozen) {
  std::vector<double> speed = rounded_steps();
  std::vector<char> used(kSamples, 1);
  for (const Finding& finding : repair_samples(speed, used, {0.0, kPeriod_s, kPeriod_s}, "velocity_z")) {
    EXPECT_NE(finding.what, "frozen") << finding.text;
  }
}

// And one that freezes while it moves is found.
TEST(RoundedSignal, IsFrozenWhereItStopsInMotion) {
  std::vector<double> speed(kSamples);
  for (std::size_t i = 0; i < speed.size(); ++i) {
    const double t_s = kPeriod_s * static_cast<double>(i);
    speed[i] = 0.01 * std::round(100.0 * (0.4 * std::sin(2.0 * t_s) + 0.2 * std::sin(5.0 * t_s)));
  }
  std::fill(speed.begin() + 3000, speed.begin() + 3120, speed[3000]);
  std::vector<char> used(kSamples, 1);
  const std::vector<Finding> found = repair_samples(speed, used, {0.0, kPeriod_s, kPeriod_s}, "velocity_z");
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.front().what, "frozen");
}

}  // namespace
}  // namespace m100::lab::identify
