// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/setpoint_planner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <numbers>

#include "firmware/mpc/generated/gain_table.h"

namespace m100::ctl {
namespace {

constexpr core::Duration kLead = std::chrono::milliseconds(50);
constexpr double kTick_s = 0.01;
const double kCombined = std::tan(std::numbers::pi / 6.0);

ref::Window<double> setpoint(double x_m, double y_m) {
  ref::Window<double> window;
  window.x.fill({.position_m = x_m});
  window.y.fill({.position_m = y_m});
  window.constant = true;
  return window;
}

/// An aircraft that follows the window after its lead, with a share of the acceleration, and the planner in front of
/// it.
class Flight {
 public:
  explicit Flight(double gain = 1.0)
      : gain_(gain),
        planner_(ctl::braking_of(mpc::generated::kVehicle, 0.408),
                 mpc::GainTables<double>{.x = mpc::generated::kX<double>, .y = mpc::generated::kY<double>}, kCombined) {
  }
  /// @returns the window of this tick.
  ref::Window<double> tick(double x_m, double y_m, bool constant = true) {
    ref::Window<double> window = setpoint(x_m, y_m);
    window.constant = constant;
    planner_.update(window, estimate_, now_, kLead, window.x.size());
    now_ += core::kTickPeriod;
    coming_.push_back(window);
    if (static_cast<long>(coming_.size()) > kLead / core::kTickPeriod) {
      move(estimate_.x, coming_.front().x[0], 1.0);
      move(estimate_.y, coming_.front().y[0], -1.0);
      coming_.pop_front();
    }
    return window;
  }
  est::Estimate<double>& estimate() { return estimate_; }

 private:
  void move(est::AxisEstimate<double>& axis, const ref::AxisReference<double>& reference, double sign) const {
    const double error_m_s2 =
        4.0 * (reference.velocity_m_s - axis.velocity_m_s) + 4.0 * (reference.position_m - axis.position_m);
    const double wanted_m_s2 = std::clamp(reference.acceleration_m_s2 + error_m_s2, -4.6, 4.6);
    const double a_m_s2 = gain_ * wanted_m_s2;
    axis.tilt_rad = sign * std::atan(a_m_s2 / model::kGravity_m_s2);
    axis.position_m += kTick_s * (axis.velocity_m_s + 0.5 * kTick_s * a_m_s2);
    axis.velocity_m_s += kTick_s * a_m_s2;
  }

  double gain_;
  SetpointPlanner<double> planner_;
  est::Estimate<double> estimate_{};
  core::TimePoint now_{std::chrono::seconds(1)};
  std::deque<ref::Window<double>> coming_;
};

TEST(SetpointPlanner, MakesAMotionOfAJumpAndEndsAtTheSetPoint) {
  Flight flight;
  flight.tick(0.0, 0.0);
  int moving = 0;
  double farthest_m = 0.0, largest_m_s2 = 0.0;
  for (int i = 0; i < 500; ++i) {
    const ref::Window<double> window = flight.tick(6.0, 0.0);
    moving += window.constant ? 0 : 1;
    for (const ref::AxisReference<double>& at : window.x) {
      farthest_m = std::max(farthest_m, at.position_m);
      largest_m_s2 = std::max(largest_m_s2, std::abs(at.acceleration_m_s2));
    }
    EXPECT_EQ(window.y[20].position_m, 0.0);
  }
  EXPECT_LE(farthest_m, 6.0 + 1e-6);
  EXPECT_LE(largest_m_s2, model::kGravity_m_s2 * std::tan(25.0 * std::numbers::pi / 180.0) + 1e-6);
  EXPECT_GT(moving, 230);  // 2 sqrt(6 m / 4.57 m/s^2) = 2.3 s without any limit of the jerk
  EXPECT_LT(moving, 280);
  const ref::Window<double> end = flight.tick(6.0, 0.0);
  EXPECT_TRUE(end.constant);
  EXPECT_EQ(end.x[0].position_m, 6.0);
}

TEST(SetpointPlanner, BothAxesTogetherKeepTheLawsLimit) {
  Flight flight;
  flight.tick(0.0, 0.0);
  double largest = 0.0;
  for (int i = 0; i < 300; ++i) {
    const ref::Window<double> window = flight.tick(6.0, -4.0);
    largest = std::max(largest, std::hypot(window.x[0].acceleration_m_s2, window.y[0].acceleration_m_s2));
  }
  EXPECT_LE(largest, kCombined * model::kGravity_m_s2 + 1e-6);
  EXPECT_GT(largest, 0.9 * kCombined * model::kGravity_m_s2);
}

TEST(SetpointPlanner, LeavesACourseAndANearGoalAlone) {
  Flight flight;
  flight.tick(0.0, 0.0);
  EXPECT_EQ(flight.tick(6.0, 0.0, false).x[0].position_m, 6.0);
  Flight near;
  near.tick(0.0, 0.0);
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(near.tick(0.04, 0.0).constant);
  }
}

TEST(SetpointPlanner, ANewGoalOnTheWayContinuesTheMotion) {
  Flight flight;
  flight.tick(0.0, 0.0);
  ref::AxisReference<double> before{};
  for (int i = 0; i < 600; ++i) {
    const ref::AxisReference<double> now = flight.tick(i < 120 ? 10.0 : -2.0, 0.0).x[0];
    EXPECT_LT(std::abs(now.position_m - before.position_m), 0.1) << i;
    EXPECT_LT(std::abs(now.velocity_m_s - before.velocity_m_s), 0.1) << i;
    before = now;
  }
  EXPECT_EQ(before.position_m, -2.0);
}

// Catches a plan that trusts the vehicle file's gain when the aircraft has shown another one.
TEST(SetpointPlanner, AnAircraftWithLessGainBrakesSooner) {
  Flight weak(0.8);
  weak.tick(0.0, 0.0);
  double farthest_m = 0.0;
  for (int i = 0; i < 1500; ++i) {
    weak.tick(30.0, 0.0);
    farthest_m = std::max(farthest_m, weak.estimate().x.position_m);
  }
  // Braking at 0.95 of the file's authority ends (1 / 0.8 - 1 / 0.95) v^2 / 2a = 2.8 m too far from 11.5 m/s.
  EXPECT_LT(farthest_m, 31.0);
}

TEST(SetpointPlanner, PlansFromWhereTheAircraftIsAfterItWasPushedAway) {
  for (const bool in_x : {true, false}) {
    Flight flight;
    const auto tick = [&] { return flight.tick(in_x ? 10.0 : 0.0, in_x ? 0.0 : 10.0); };
    flight.tick(0.0, 0.0);
    for (int i = 0; i < 100; ++i) {
      tick();
    }
    est::AxisEstimate<double>& axis = in_x ? flight.estimate().x : flight.estimate().y;
    axis.position_m -= 1.0;
    const ref::Window<double> first = tick(), second = tick();  // one axis is planned a tick
    const double planned_m = in_x ? second.x[0].position_m : second.y[0].position_m;
    EXPECT_NEAR(planned_m, axis.position_m + 0.05 * axis.velocity_m_s, 0.1) << first.constant;
  }
}

}  // namespace
}  // namespace m100::ctl
