// SPDX-License-Identifier: BSD-3-Clause
// The time-optimal motion of one axis: limits, end, duration against two independent computations, and the fence.
#include "firmware/ref/time_optimal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace m100::ref {
namespace {

using State = AxisReference<double>;
using Limits = AxisLimits<double>;

constexpr int kDraws = 20000;
constexpr int kPoints = 200;

/// Random limits and states inside them.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  Limits limits(double braking_share, double release_share = 1.0) {
    const double jerk_m_s3 = between(3.0, 40.0);
    return {.speed_m_s = between(1.0, 15.0),
            .up_m_s2 = between(0.5, 6.0),
            .down_m_s2 = between(0.5, 6.0),
            .braking_share = braking_share,
            .jerk_m_s3 = jerk_m_s3,
            .release_m_s3 = release_share * jerk_m_s3};
  }
  State state(const Limits& limits) {
    // The acceleration can end before the speed is at its limit.
    const double by_speed = std::sqrt(2.0 * limits.jerk_m_s3 * limits.speed_m_s);
    State state{
        .position_m = between(-40.0, 40.0),
        .acceleration_m_s2 = between(-std::min(limits.down_m_s2, by_speed), std::min(limits.up_m_s2, by_speed))};
    const double turning = state.acceleration_m_s2 * state.acceleration_m_s2 / (2.0 * limits.jerk_m_s3);
    state.velocity_m_s = between(turning - limits.speed_m_s, limits.speed_m_s - turning);
    return state;
  }

 private:
  std::mt19937_64 random_;
};

/// The textbook's double S from rest to rest (Biagiotti and Melchiorri, 2008, 3.4) with one limit in both directions.
double double_s_duration(double way, double v, double a, double j) {
  const double ramp = v * j < a * a ? std::sqrt(v / j) : a / j;
  const double to_speed = v * j < a * a ? 2.0 * ramp : ramp + v / a;
  if (way >= v * to_speed) {
    return way / v + to_speed;
  }
  const double by_jerk = std::cbrt(way / (2.0 * j));
  if (by_jerk * j <= a) {
    return 4.0 * by_jerk;
  }
  const double t = a / j;
  return t + std::sqrt(t * t + 4.0 * way / a);
}

/// Raises the acceleration from rest until the switch and then stops as fast as the limits allow, integrated
/// numerically. @returns the duration.
double integrate_motion(double switch_s, const Limits& limits, double& end_m) {
  constexpr double kStep_s = 5e-4;
  double t = 0.0, v = 0.0, a = 0.0;
  end_m = 0.0;
  while (t < switch_s || v > 0.0) {
    const double left = v - 0.5 * a * a / limits.jerk_m_s3;  // after raising the acceleration to zero at once
    const double target = t < switch_s ? limits.up_m_s2 : a < 0.0 && left <= 0.0 ? 0.0 : -limits.down_m_s2;
    a += std::clamp(target - a, -limits.jerk_m_s3 * kStep_s, limits.jerk_m_s3 * kStep_s);
    v += a * kStep_s;
    end_m += v * kStep_s;
    t += kStep_s;
    if (a >= 0.0 && t > switch_s && left <= 0.0) {
      break;
    }
  }
  return t;
}

/// The shortest time from rest to rest by brute force: a bisection of the time at which the motion begins to stop.
double integrated_duration(double way, const Limits& limits) {
  double low = 0.0, high = 60.0, t = 0.0;
  for (int i = 0; i < 40; ++i) {
    double end_m = 0.0;
    const double middle = 0.5 * (low + high);
    t = integrate_motion(middle, limits, end_m);
    (end_m < way ? low : high) = middle;
  }
  return t;
}

TEST(TimeOptimal, KeepsItsLimitsAndEndsExactlyAtTheGoal) {
  Draw draw(37);
  for (int i = 0; i < kDraws; ++i) {
    const Limits limits = draw.limits(draw.between(0.6, 1.0), i % 2 == 0 ? 1.0 : draw.between(0.3, 1.0));
    const State from = draw.state(limits);
    const double goal_m = draw.between(-40.0, 40.0);
    TimeOptimal<double> motion;
    motion.plan(from, goal_m, limits);
    ASSERT_LT(motion.duration_s(), 200.0) << i;
    State before = motion.at(0.0);
    ASSERT_NEAR(before.position_m, from.position_m, 1e-9) << i;
    ASSERT_NEAR(before.velocity_m_s, from.velocity_m_s, 1e-9) << i;
    const double step_s = motion.duration_s() / kPoints;
    for (int k = 1; k < kPoints; ++k) {
      const State now = motion.at(k * step_s);
      ASSERT_LE(now.acceleration_m_s2, limits.up_m_s2 + 1e-9) << i;
      ASSERT_GE(now.acceleration_m_s2, -limits.down_m_s2 - 1e-9) << i;
      ASSERT_LE(std::abs(now.velocity_m_s), limits.speed_m_s + 1e-9) << i;
      ASSERT_LE(std::abs(now.acceleration_m_s2 - before.acceleration_m_s2), limits.jerk_m_s3 * step_s + 1e-9) << i;
      before = now;
    }
    const State last = motion.at(motion.duration_s() * (1.0 - 1e-9));
    EXPECT_NEAR(last.position_m, goal_m, 1e-6) << i;
    EXPECT_NEAR(last.velocity_m_s, 0.0, 1e-6) << i;
    const State end = motion.at(motion.duration_s());
    EXPECT_EQ(end.position_m, goal_m);
    EXPECT_EQ(end.velocity_m_s, 0.0);
    EXPECT_EQ(end.acceleration_m_s2, 0.0);
  }
}

TEST(TimeOptimal, FromRestToRestTakesTheTimeOfTheTextbook) {
  Draw draw(38);
  for (int i = 0; i < kDraws; ++i) {
    Limits limits = draw.limits(1.0);
    limits.down_m_s2 = limits.up_m_s2;
    const double way_m = draw.between(0.01, 60.0);
    TimeOptimal<double> motion;
    motion.plan({}, i % 2 == 0 ? way_m : -way_m, limits);
    EXPECT_NEAR(motion.duration_s(), double_s_duration(way_m, limits.speed_m_s, limits.up_m_s2, limits.jerk_m_s3), 1e-6)
        << i;
  }
}

TEST(TimeOptimal, WithUnequalLimitsItTakesTheTimeThatABisectionFinds) {
  Draw draw(39);
  for (int i = 0; i < 20; ++i) {
    Limits limits = draw.limits(1.0);
    limits.speed_m_s = 1000.0;
    const double way_m = draw.between(0.5, 40.0);
    TimeOptimal<double> motion;
    motion.plan({}, way_m, limits);
    const double found_s = integrated_duration(way_m, limits);
    EXPECT_NEAR(motion.duration_s(), found_s, 0.01 * found_s) << i;  // the one per cent
  }
}

// Bellman: what is left of a fastest motion is the fastest motion from there. It reaches states that no motion from
// rest to rest begins with.
TEST(TimeOptimal, PlannedAgainOnItsWayItTakesTheTimeThatIsLeft) {
  Draw draw(40);
  for (int i = 0; i < kDraws; ++i) {
    const Limits limits = draw.limits(1.0);
    TimeOptimal<double> motion;
    motion.plan(draw.state(limits), draw.between(-40.0, 40.0), limits);
    const double since_s = draw.between(0.0, motion.duration_s());
    TimeOptimal<double> again;
    again.plan(motion.at(since_s), motion.goal_m(), limits);
    ASSERT_NEAR(again.duration_s(), motion.duration_s() - since_s, 2e-3) << i;
  }
}

// Where it can stop before the goal it never passes it: what keeps a goal inside the fence keeps the motion inside.
TEST(TimeOptimal, NeverPassesAGoalThatItCanStopBefore) {
  Draw draw(41);
  int checked = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Limits limits = draw.limits(0.9);
    State from = draw.state(limits);
    from.velocity_m_s = std::abs(from.velocity_m_s);
    from.acceleration_m_s2 = std::max(from.acceleration_m_s2, 0.0);
    const double a = from.acceleration_m_s2, b = 0.9 * limits.down_m_s2, j = limits.jerk_m_s3;
    const double reversal_s = (a + b) / j;
    const double fastest = from.velocity_m_s + a * a / (2.0 * j);
    const double goal_m = from.position_m + fastest * (reversal_s + b / j) + fastest * fastest / (2.0 * b);
    TimeOptimal<double> motion;
    motion.plan(from, goal_m, limits);
    for (int k = 0; k <= kPoints; ++k) {
      ASSERT_LE(motion.at(motion.duration_s() * k / kPoints).position_m, goal_m + 1e-6) << i;
    }
    ++checked;
  }
  EXPECT_EQ(checked, kDraws);
}

TEST(TimeOptimal, AFasterStartThanAllowedIsNotMadeFaster) {
  TimeOptimal<double> motion;
  motion.plan({.velocity_m_s = 8.0}, 50.0,
              {.speed_m_s = 5.0,
               .up_m_s2 = 4.0,
               .down_m_s2 = 4.0,
               .braking_share = 1.0,
               .jerk_m_s3 = 20.0,
               .release_m_s3 = 20.0});
  for (int k = 0; k <= kPoints; ++k) {
    EXPECT_LE(motion.at(motion.duration_s() * k / kPoints).velocity_m_s, 8.0 + 1e-9);
  }
}

TEST(TimeOptimal, FloatFollowsDouble) {
  Draw draw(42);
  for (int i = 0; i < kDraws; ++i) {
    const Limits limits = draw.limits(0.95);
    const State from = draw.state(limits);
    TimeOptimal<double> motion;
    motion.plan(from, 3.0, limits);
    TimeOptimal<float> narrow;
    narrow.plan(
        {static_cast<float>(from.position_m), static_cast<float>(from.velocity_m_s),
         static_cast<float>(from.acceleration_m_s2)},
        3.0F,
        {static_cast<float>(limits.speed_m_s), static_cast<float>(limits.up_m_s2), static_cast<float>(limits.down_m_s2),
         0.95F, static_cast<float>(limits.jerk_m_s3), static_cast<float>(limits.release_m_s3)});
    const double half_s = 0.5 * motion.duration_s();
    // 1e-3 m: a rounding of the state by 4e-6, over the steepest dependence of the switching times on it.
    EXPECT_NEAR(static_cast<double>(narrow.at(static_cast<float>(half_s)).position_m), motion.at(half_s).position_m,
                1e-3)
        << i;
  }
}

TEST(TimeOptimal, TheWindowIsTheMotionEveryTenthOfASecond) {
  TimeOptimal<double> motion;
  motion.plan({}, 6.0,
              {.speed_m_s = 17.0,
               .up_m_s2 = 4.5,
               .down_m_s2 = 4.5,
               .braking_share = 0.95,
               .jerk_m_s3 = 26.0,
               .release_m_s3 = 13.0});
  std::array<State, kHorizon + 1> window{};
  motion.fill(window, 0.35);
  for (std::size_t k = 0; k < window.size(); ++k) {
    EXPECT_NEAR(window[k].position_m, motion.at(0.35 + 0.1 * static_cast<double>(k)).position_m, 1e-12);
  }
  EXPECT_EQ(window.back().position_m, motion.at(2.35).position_m);
}

}  // namespace
}  // namespace m100::ref
