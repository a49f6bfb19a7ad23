// SPDX-License-Identifier: BSD-3-Clause
// Healthy logs that look defective: pulses of a program, a rounded signal that rests and then moves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host_tests/lab/identify/data/log_defects.h"

namespace m100::lab::identify {
namespace {

constexpr double kPeriod_s = 0.01;
constexpr std::size_t kSamples = 6000;

/// Pulses of 0.3 to 1.8 s to both sides.
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

/// Slow movements of a hand, cut off at the limits of the log's range.
std::vector<double> cut_hand() {
  std::vector<double> out(kSamples);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double t_s = kPeriod_s * static_cast<double>(i);
    out[i] = std::clamp(200.0 * std::sin(2.1 * t_s) + 120.0 * std::sin(5.3 * t_s + 1.0), -120.0, 120.0);
  }
  return out;
}

// Catches a log of pulses, a classic excitation, that is refused because the stick seems to be at its stops.
TEST(CutShare, IsThatOfAHandAndNotOfPulses) {
  const std::vector<char> used(kSamples, 1);
  const SampleGrid clock{0.0, kPeriod_s, kPeriod_s};
  EXPECT_EQ(clipped_share(pulses(), used, clock), 0.0);
  EXPECT_GT(clipped_share(cut_hand(), used, clock), 0.2);
}

// Rows of 0.1 s cannot tell the two apart, so the doubt remains.
TEST(CutShare, StaysInDoubtWhereRowsAreSlow) {
  const std::vector<char> used(kSamples, 1);
  EXPECT_GT(clipped_share(pulses(), used, {0.0, kPeriod_s, 0.1}), 0.9);
}

/// A climb speed that is rounded to 0.01 m/s: it rests on one value for two seconds, then follows a pulse of the stick.
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

// Catches a resting signal that is called frozen because it is quantised and then starts to move.
TEST(RoundedSignal, RestsAndStartsWithoutBeingFrozen) {
  std::vector<double> speed = rounded_steps();
  std::vector<char> used(kSamples, 1);
  for (const Finding& finding : repair_samples(speed, used, {0.0, kPeriod_s, kPeriod_s}, "velocity_z")) {
    EXPECT_NE(finding.what, "frozen") << finding.text;
  }
}

// A signal that freezes in motion must still be found.
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
