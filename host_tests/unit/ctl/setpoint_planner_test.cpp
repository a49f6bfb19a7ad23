// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/setpoint_planner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <tuple>

#include "firmware/mpc/generated/gain_table.h"

namespace m100::ctl {
namespace {

constexpr core::Duration kLead = std::chrono::milliseconds(50);
constexpr double kTick_s = 0.01;

ref::Window<double> setpoint(double x_m, double y_m) {
  ref::Window<double> window;
  window.x.fill({.position_m = x_m});
  window.y.fill({.position_m = y_m});
  window.constant = true;
  return window;
}

/// The planner and, beside it, the motion of x that its header's limits give, which the aircraft follows exactly.
struct PlannerNumbers : ::testing::Test {
  static constexpr double kLead_s = 0.05, kReaction_s = 0.4, kActs_s = 0.1;
  mpc::GainTables<double> gains{.x = mpc::generated::kX<double>, .y = mpc::generated::kY<double>};
  SetpointPlanner<double> planner{{.reaction_s = kReaction_s, .acts_s = kActs_s}, changed(gains), 0.6};
  GeofenceLimiter<double> fence{core::Fence{}, {.acceleration_m_s2 = 3.0, .reaction_s = kReaction_s}};
  est::Estimate<double> estimate;
  ref::TimeOptimal<double> motion;
  ref::Window<double> window;
  double time_s = 0.0;  ///< of the motion
  core::TimePoint now{std::chrono::seconds(1)};

  static const mpc::GainTables<double>& changed(mpc::GainTables<double>& gains) {
    gains.x.input_gain = 1.1;
    gains.x.input_max_slope = 0.3;  // a slope of 0.33
    gains.y.input_gain = 0.9;
    gains.y.input_min_slope = -0.35;  // 0.315
    gains.y.acceleration_per_tilt = 9.0;
    return gains;
  }
  static ref::AxisLimits<double> limits(double tilted_m_s2, double authority, double wind_m_s2, double at_rest_m_s2) {
    const double wind_then_m_s2 = wind_m_s2 + (at_rest_m_s2 - wind_m_s2) / 3.0;
    return {.speed_m_s = 17.0,
            .up_m_s2 = std::max(authority * tilted_m_s2 + wind_then_m_s2, 0.25 * tilted_m_s2),
            .down_m_s2 = std::max(authority * tilted_m_s2 - wind_then_m_s2, 0.25 * tilted_m_s2),
            .braking_share = 0.95,
            .jerk_m_s3 = 2.0 * tilted_m_s2 / (kReaction_s - kActs_s),
            .release_m_s3 = 0.5 * tilted_m_s2 / kReaction_s};
  }
  static ref::AxisReference<double> ahead(const est::AxisEstimate<double>& axis, double per_slope_m_s2) {
    const double a_m_s2 = per_slope_m_s2 * std::tan(axis.tilt_rad) + axis.disturbance_m_s2;
    return {.position_m = axis.position_m + kLead_s * axis.velocity_m_s + 0.5 * kLead_s * kLead_s * a_m_s2,
            .velocity_m_s = axis.velocity_m_s + kLead_s * a_m_s2,
            .acceleration_m_s2 = a_m_s2};
  }
  void tick(double x_m, double y_m) {
    window = setpoint(x_m, y_m);
    planner.update(window, estimate, fence, now, kLead, window.x.size());
    now += core::kTickPeriod;
  }
  static bool equal(const auto& axis, const ref::TimeOptimal<double>& wanted, double first_s) {
    for (std::size_t k = 0; k < axis.size(); ++k) {
      const ref::AxisReference<double> r = wanted.at(first_s + 0.1 * static_cast<double>(k));
      if (std::abs(axis[k].position_m - r.position_m) + std::abs(axis[k].velocity_m_s - r.velocity_m_s) +
              std::abs(axis[k].acceleration_m_s2 - r.acceleration_m_s2) >
          1e-8) {
        return false;
      }
    }
    return true;
  }
  /// From rest to `goal_m`, followed for `for_s`.
  void follow(double goal_m, double for_s) {
    const est::AxisEstimate<double> start = estimate.x;
    tick(goal_m, 0.0);
    motion.plan(ahead(start, 9.8066), goal_m, limits(9.8066 * 0.33, 1.0, 0.0, 0.0));
    ASSERT_TRUE(equal(window.x, motion, 0.0));
    time_s = 0.0;
    keep_up();
    follow_on(goal_m, for_s);
  }
  void follow_on(double goal_m, double until_s) {
    for (; time_s < until_s - 1e-9; keep_up()) {
      tick(goal_m, 0.0);
      ASSERT_TRUE(window.constant || equal(window.x, motion, time_s)) << time_s;
    }
  }
  /// The aircraft is where the motion was one lead before.
  void keep_up() {
    time_s += kTick_s;
    const ref::AxisReference<double> at = motion.at(time_s - kLead_s);
    estimate.x.position_m = at.position_m;
    estimate.x.velocity_m_s = at.velocity_m_s;
    estimate.x.tilt_rad = std::atan((at.acceleration_m_s2 - estimate.x.disturbance_m_s2) / 9.8066);
  }
};

// Each axis with its own limits, shared in the direction of the goal; one axis is planned a tick.
TEST_F(PlannerNumbers, PlansWithTheLimitsOfItsEquations) {
  struct Case {
    double x_m, y_m, wind_m_s2, slope_x, slope_y;  ///< the slopes: shared, by the table, at least a quarter
  };
  const double away_m = std::hypot(3.0, 4.0);
  for (const Case& one : {Case{3.5, -4.25, 0.4, 0.33, 0.315}, Case{0.95 + 0.5, -8.0, -0.4, 0.15, 0.315},
                          Case{0.5 + 0.45 * away_m, -0.25 + away_m * 0.89302855497459, 2.7, 0.27, 0.315},
                          Case{9.0, -0.2, -3.9, 0.33, 0.15}}) {
    estimate.x = {0.5, 0.2, 0.05, 0.0, one.wind_m_s2};
    estimate.y = {-0.25, -0.1, 0.04, 0.0, -one.wind_m_s2};
    tick(one.x_m, one.y_m);
    motion.plan(ahead(estimate.x, 9.8066), one.x_m, limits(9.8066 * one.slope_x, 1.0, one.wind_m_s2, one.wind_m_s2));
    EXPECT_TRUE(equal(window.x, motion, 0.0)) << one.x_m;
    EXPECT_FALSE(window.constant);
    tick(one.x_m, one.y_m);
    EXPECT_TRUE(equal(window.x, motion, 0.01)) << one.x_m;
    motion.plan(ahead(estimate.y, -9.0), one.y_m, limits(9.0 * one.slope_y, 1.0, -one.wind_m_s2, -one.wind_m_s2));
    EXPECT_TRUE(equal(window.y, motion, 0.0)) << one.y_m;
    planner.reset();
  }
}

TEST_F(PlannerNumbers, LeavesACourseAndANearGoalAlone) {
  for (const auto& [goal_m, velocity_m_s] : {std::pair{0.048, 0.0}, {0.0, 0.048}, {-0.052, 0.0}, {0.0, -0.052}}) {
    planner.reset();
    estimate.x.velocity_m_s = velocity_m_s;
    tick(goal_m, 0.0);
    EXPECT_EQ(window.constant, std::abs(goal_m + velocity_m_s) < 0.05);
  }
  tick(3.0, 0.03);
  EXPECT_FALSE(window.constant);
  EXPECT_EQ(window.y[7].position_m, 0.03);
  window.constant = false;
  window.x.fill({.position_m = 6.0});
  planner.update(window, estimate, fence, now, kLead, window.x.size());
  EXPECT_EQ(window.x[0].position_m, 6.0);
}

TEST_F(PlannerNumbers, EndsAtTheSetPointAndContinuesToANewOne) {
  follow(6.0, 0.02);
  follow_on(6.0, motion.duration_s() - 0.005);
  EXPECT_FALSE(window.constant);
  follow_on(6.0, motion.duration_s() + 0.1);
  EXPECT_TRUE(window.constant);
  EXPECT_EQ(window.x[0].position_m, 6.0);
  follow(10.0, 1.2);
  const ref::AxisReference<double> from = motion.at(time_s);
  tick(-2.0, 0.0);
  motion.plan(from, -2.0, limits(9.8066 * 0.33, 1.0, 0.0, 0.0));
  EXPECT_TRUE(equal(window.x, motion, 0.0));
}

// Both sides of each bound: the motion is planned again when the aircraft is 0.3 m off it or the wind has changed by
// 0.5 m/s^2, one reaction time after it began and before its end.
TEST_F(PlannerNumbers, PlansAgainBeyondItsBounds) {
  struct Case {
    double at_s, off_m, wind_m_s2;
    bool again;
  };
  for (const Case& one : {Case{0.39, 0.4, 0.0, false}, Case{0.40, 0.31, 0.0, true}, Case{1.2, -0.31, 0.0, true},
                          Case{1.2, -0.29, 0.0, false}, Case{0.39, 0.0, 0.8, false}, Case{0.40, 0.0, 0.51, true},
                          Case{1.2, 0.0, 0.49, false}, Case{1.2, 0.0, -0.52, true}, Case{1.2, 0.29, -0.49, false}}) {
    planner.reset();
    estimate = {};
    follow(9.0, one.at_s);
    estimate.x.position_m += one.off_m;
    estimate.x.disturbance_m_s2 = one.wind_m_s2;
    const ref::AxisReference<double> from = one.off_m != 0.0 ? ahead(estimate.x, 9.8066) : motion.at(time_s);
    tick(9.0, 0.0);
    EXPECT_EQ(equal(window.x, motion, time_s), !one.again) << one.at_s << " " << one.off_m << " " << one.wind_m_s2;
    motion.plan(from, 9.0, limits(9.8066 * 0.33, 1.0, one.wind_m_s2, 0.0));
    EXPECT_EQ(equal(window.x, motion, 0.0), one.again) << one.at_s << " " << one.off_m << " " << one.wind_m_s2;
  }
}

// The share of the commanded tilt that the aircraft reaches is its gain, where the command was constant for a reaction
// time and at least half of what the plan may use.
TEST_F(PlannerNumbers, LearnsTheAuthorityThatTheAircraftShows) {
  struct Case {
    double at_s, share, authority;
  };
  for (const Case& one : {Case{1.0, 0.9, 0.9}, Case{1.0, 0.7, 0.8}, Case{1.0, 1.3, 1.0}, Case{0.5, 0.9, 1.0}}) {
    planner.reset();
    estimate = {};
    follow(30.0, one.at_s);
    estimate.x.position_m -= 0.31;
    estimate.x.tilt_rad = std::atan(one.share * std::tan(estimate.x.tilt_rad));
    tick(30.0, 0.0);
    motion.plan(ahead(estimate.x, 9.8066), 30.0, limits(9.8066 * 0.33, one.authority, 0.0, 0.0));
    EXPECT_TRUE(equal(window.x, motion, 0.0)) << one.at_s << " " << one.share;
  }
}

TEST_F(PlannerNumbers, PlansTenTimesForOneGoal) {
  for (const auto& [on_x, x_m, y_m] : {std::tuple{true, 200.0, 0.0}, {true, 220.0, 0.0}, {false, 220.0, 200.0}}) {
    est::AxisEstimate<double>& axis = on_x ? estimate.x : estimate.y;
    const auto& reference = on_x ? window.x[0] : window.y[0];
    int again = 0;
    for (int push = 0; push < 13; ++push) {
      for (int k = 0; k < 45; ++k) {  // follows the window, without its lead
        tick(x_m, y_m);
        axis.position_m = reference.position_m - kLead_s * reference.velocity_m_s;
        axis.velocity_m_s = reference.velocity_m_s;
      }
      const double before_m = reference.position_m;
      axis.position_m -= 1.0;
      tick(x_m, y_m);
      again += reference.position_m < before_m - 0.5 ? 1 : 0;
    }
    EXPECT_EQ(again, 10);
  }
}

}  // namespace
}  // namespace m100::ctl
