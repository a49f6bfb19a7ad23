// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/command_consistency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace m100::est {
namespace {

constexpr double kTick_s = 0.01;
using Vector2 = core::Vector<double, 2>;

/// Commands that alternate on both axes, as fast as an oscillating loop.
Vector2 asked(double t_s) { return {0.1 * std::sin(2.5 * t_s), 0.08 * std::cos(3.1 * t_s)}; }

class CommandConsistencyTest : public ::testing::Test {
 protected:
  /// @returns after what time the tilt is called unanswered, or the time flown.
  double fly(double seconds, const std::function<Vector2(double t_s)>& reported, bool ours = true, double size = 1.0) {
    for (double t_s = 0.0; t_s < seconds; t_s += kTick_s) {
      Estimate<double> estimate;
      const Vector2 tilt = reported(t_s);
      estimate.x.tilt_rad = tilt.x();
      estimate.y.tilt_rad = tilt.y();
      check_.update(estimate, size * asked(t_s), ours, kTick_s);
      if (check_.contradicts_command()) {
        return t_s;
      }
    }
    return seconds;
  }

  CommandConsistency<double> check_;
};

TEST_F(CommandConsistencyTest, AnAircraftThatAnswersUnlikeItsModelAnswers) {
  RecordProperty("promise", "R17");
  const Vector2 trim(0.05, -0.03);
  const std::function<Vector2(double)> answers[] = {
      [&](double t_s) { return Vector2(asked(t_s) + trim); },
      [&](double t_s) { return Vector2(1.5 * asked(t_s - 0.1) + trim); },
      [&](double t_s) { return Vector2(0.6 * asked(t_s - 0.1) + trim); },
      [&](double t_s) { return Vector2(asked(t_s - 0.2) + trim); },
  };
  for (const auto& answer : answers) {
    check_ = {};
    EXPECT_EQ(fly(20.0, answer), 20.0);
  }
}

TEST_F(CommandConsistencyTest, ATiltWithOtherAxesDoesNotAnswer) {
  RecordProperty("promise", "R14");
  const std::function<Vector2(double)> lies[] = {
      [](double t_s) { return Vector2(asked(t_s).y(), asked(t_s).x()); },
      [](double t_s) { return Vector2(-asked(t_s).x(), asked(t_s).y()); },
      [](double t_s) { return Vector2(asked(t_s).x(), -asked(t_s).y()); },
      [](double t_s) { return Vector2(-asked(t_s)); },
  };
  for (const auto& lie : lies) {
    check_ = {};
    EXPECT_LT(fly(20.0, lie), 1.0);
  }
}

// Catches a check that divides by the small motion of a still hover, and one that takes the pilot's sticks for ours.
TEST_F(CommandConsistencyTest, SaysNothingWhileNothingIsAskedOrTheSticksAreThePilots) {
  RecordProperty("promise", "R17");
  const auto shakes = [](double t_s) { return Vector2(0.006 * std::sin(9.0 * t_s), 0.006 * std::cos(7.0 * t_s)); };
  EXPECT_EQ(fly(20.0, shakes, true, 0.05), 20.0);
  EXPECT_EQ(fly(
                20.0, [](double t_s) { return Vector2(-asked(t_s)); }, false),
            20.0);
}

}  // namespace
}  // namespace m100::est
