// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/command_consistency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace m100::est {
namespace {

constexpr double kTick_s = 0.01, kGravity_m_s2 = 9.81;
using Vector2 = core::Vector<double, 2>;
using Tilt = std::function<Vector2(double t_s)>;

/// Accelerations [m/s^2] of commands that alternate on both axes, as fast as an oscillating loop.
Vector2 asked(double t_s) { return kGravity_m_s2 * Vector2(0.1 * std::sin(2.5 * t_s), 0.08 * std::cos(3.1 * t_s)); }

/// An aircraft, its attitude and its poses, each with its acceleration [m/s^2].
struct Witnesses {
  Tilt flown;     ///< by the true tilt
  Tilt reported;  ///< by the attitude
  Tilt seen;      ///< by the poses
};

class CommandConsistencyTest : public ::testing::Test {
 protected:
  /// @returns after what time the commands contradict the attitude, or the time flown.
  double fly(double seconds, const Witnesses& by, const Tilt& commands, bool ours = true, bool poses_come = true) {
    CommandConsistency<double> check;
    Vector2 apart_m_s = Vector2::Zero();
    for (double t_s = 0.0; t_s < seconds; t_s += kTick_s) {
      apart_m_s += (by.seen(t_s) - by.reported(t_s)) * kTick_s;
      check.update(apart_m_s, {.commanded_m_s2 = commands(t_s), .reported_m_s2 = by.reported(t_s)}, poses_come, ours,
                   kTick_s);
      if (check.contradicts_command()) {
        return t_s;
      }
    }
    return seconds;
  }
  static Vector2 still(double) { return Vector2::Zero(); }
};

TEST_F(CommandConsistencyTest, AnAircraftThatAnswersUnlikeItsModelAnswers) {
  RecordProperty("promise", "R17");
  const Tilt answers[] = {
      asked,
      [](double t_s) { return Vector2(1.5 * asked(t_s - 0.1)); },
      [](double t_s) { return Vector2(0.6 * asked(t_s - 0.1)); },
      [](double t_s) { return asked(t_s - 0.2); },
  };
  for (const Tilt& answer : answers) {
    EXPECT_EQ(fly(20.0, {answer, answer, answer}, asked), 20.0);
  }
}

// Poses that stand or drift contradict the attitude, but an attitude that follows the commands is right.
TEST_F(CommandConsistencyTest, FalsePosesAccuseNoAttitudeThatAnswers) {
  RecordProperty("promise", "R14");
  const Tilt late = [](double t_s) { return Vector2(1.2 * asked(t_s - 0.08)); };
  EXPECT_EQ(fly(20.0, {late, late, still}, asked), 20.0);
  const Tilt drifting = [&](double t_s) { return Vector2(late(t_s) + Vector2(0.5, 0.0)); };
  EXPECT_EQ(fly(20.0, {late, late, drifting}, asked), 20.0);
}

TEST_F(CommandConsistencyTest, ATiltWithOtherAxesDoesNotAnswer) {
  RecordProperty("promise", "R14");
  const Tilt lies[] = {
      [](double t_s) { return Vector2(asked(t_s).y(), asked(t_s).x()); },
      [](double t_s) { return Vector2(-asked(t_s).x(), asked(t_s).y()); },
      [](double t_s) { return Vector2(asked(t_s).x(), -asked(t_s).y()); },
      [](double t_s) { return Vector2(-asked(t_s)); },
  };
  for (const Tilt& lie : lies) {
    EXPECT_LT(fly(20.0, {asked, lie, asked}, asked), 2.5);
  }
}

// An attitude that drifts away slowly in a still hover: the aircraft stays where it is, and so do commands and poses.
TEST_F(CommandConsistencyTest, ATiltThatDriftsAwayDoesNotAnswer) {
  RecordProperty("promise", "R14");
  for (const double rad_per_s : {0.0125, 0.05}) {
    const Tilt ramp = [=](double t_s) { return Vector2(kGravity_m_s2 * std::min(rad_per_s * t_s, 0.2), 0.0); };
    EXPECT_LT(fly(20.0, {still, ramp, still}, still), 4.0) << rad_per_s;
  }
}

// Catches a check that divides by the small motion of a still hover, one that takes the pilot's sticks for ours, and
// one that takes the motion by the commands for that of poses.
TEST_F(CommandConsistencyTest, SaysNothingWhileNothingIsAskedTheSticksAreThePilotsOrNoPoseComes) {
  RecordProperty("promise", "R17");
  const Tilt shakes = [](double t_s) { return Vector2(0.06 * std::sin(9.0 * t_s), 0.06 * std::cos(7.0 * t_s)); };
  const Tilt lie = [](double t_s) { return Vector2(-asked(t_s)); };
  EXPECT_EQ(fly(20.0, {still, shakes, still}, [](double t_s) { return Vector2(0.05 * asked(t_s)); }), 20.0);
  EXPECT_EQ(fly(20.0, {asked, lie, asked}, asked, false), 20.0);
  EXPECT_EQ(fly(20.0, {asked, lie, asked}, asked, true, false), 20.0);
}

}  // namespace
}  // namespace m100::est
