// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/campaign/oscillation.h"

#include <gtest/gtest.h>
#include <cmath>
#include <functional>
#include <numbers>

namespace m100::lab::campaign {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

experiments::Trace trace_of(const std::function<double(double t_s)>& roll_deg) {
  experiments::Trace trace(3000);
  for (std::size_t i = 0; i < trace.size(); ++i) {
    trace[i].t_s = 0.01 * static_cast<double>(i);
    trace[i].roll_rad = kRadians * roll_deg(trace[i].t_s);
  }
  return trace;
}

/// Thirty seconds with the given roll in degrees.
TiltOscillation roll_of(const std::function<double(double t_s)>& roll_deg) {
  return measure_oscillation(trace_of(roll_deg));
}

TiltOscillation sine(double frequency_hz, double amplitude_deg, double from_s = 0.0, double to_s = 30.0) {
  return roll_of([=](double t_s) {
    return t_s >= from_s && t_s < to_s ? amplitude_deg * std::sin(2.0 * std::numbers::pi * frequency_hz * t_s) : 0.0;
  });
}

TEST(Oscillation, IsAPeriodBetweenAThirdOfAHertzAndThree) {
  // A sine of amplitude a has a root mean square of a / sqrt(2): 4.3 degrees are 3.04, 4.2 are 2.97.
  EXPECT_TRUE(sine(1.0, 4.3).periodic);
  EXPECT_FALSE(sine(1.0, 4.2).periodic);
  EXPECT_TRUE(sine(0.45, 20.0).periodic);
  EXPECT_TRUE(sine(2.8, 10.0).periodic);
  EXPECT_FALSE(sine(0.02, 20.0).periodic);  // the mean over two seconds follows it
}

TEST(Oscillation, IsSeenWhereItLastsFiveSeconds) { EXPECT_TRUE(sine(1.0, 10.0, 12.0, 17.5).periodic); }

TEST(Oscillation, IsNoLeanAndNoChangeOfLean) {
  EXPECT_FALSE(roll_of([](double) { return 20.0; }).periodic);
  EXPECT_FALSE(roll_of([](double t_s) { return t_s < 15.0 ? 0.0 : 15.0; }).periodic);
}

TEST(Oscillation, IsNoCourseThatRepeatsAndIsFlownLate) {
  const auto course = [](double t_s) { return 6.0 * std::sin(2.0 * std::numbers::pi * 0.4 * t_s); };
  const auto kind = trace_of(course);
  const auto late = [&](double t_s) { return course(t_s - 0.1); };
  EXPECT_TRUE(roll_of(late).periodic);
  EXPECT_FALSE(measure_oscillation(trace_of(late), kind).periodic);
  const auto swings = [&](double t_s) { return late(t_s) + 6.0 * std::sin(2.0 * std::numbers::pi * t_s); };
  EXPECT_TRUE(measure_oscillation(trace_of(swings), kind).periodic);
}

TEST(Oscillation, IsComparedWithTheNominalWorld) {
  const TiltOscillation wild = sine(1.0, 10.0);
  const TiltOscillation calm = sine(1.0, 0.5);
  EXPECT_TRUE(oscillates(wild, calm, false));
  EXPECT_FALSE(oscillates(wild, wild, false));
  EXPECT_FALSE(is_surely_steady(wild, false));
  EXPECT_TRUE(is_surely_steady(calm, true));
}

TEST(Oscillation, OfAHoverIsAlsoTwiceTheSwayOfTheKindWorld) {
  const TiltOscillation slow = sine(0.05, 4.0);  // 2.8 degrees, too slow for a period
  EXPECT_FALSE(slow.periodic);
  EXPECT_FALSE(is_surely_steady(slow, true));
  EXPECT_TRUE(is_surely_steady(slow, false));
  EXPECT_TRUE(oscillates(slow, sine(0.05, 1.9), true));
  EXPECT_FALSE(oscillates(slow, sine(0.05, 2.1), true));
  EXPECT_FALSE(oscillates(slow, sine(0.05, 1.9), false));
}

}  // namespace
}  // namespace m100::lab::campaign
