// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/geofence_limiter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <numbers>
#include <string>
#include <vector>

#include "firmware/ctl/law/brake_and_hold.h"
#include "firmware/mpc/generated/gain_table.h"

namespace m100::ctl {
namespace {

core::Fence box() { return {.side = {core::Fence::Side{-5, 5}, core::Fence::Side{-5, 5}, core::Fence::Side{0.5, 4}}}; }

/// Braking of the shipped vehicle: the law gives each axis 22.2 degrees when both brake.
Braking shipped() { return braking_of(mpc::generated::kVehicle, 0.408); }

ref::Window<double> goal(double x_m, double z_m) {
  ref::Window<double> window;
  window.x.fill({.position_m = x_m, .velocity_m_s = 1.0});
  window.height = {.position_m = z_m};
  window.constant = true;
  return window;
}

TEST(GeofenceLimiter, LeavesGoalsInsideAlone) {
  GeofenceLimiter<double> limiter(box(), shipped());
  EXPECT_FALSE(limiter.brakes());
  est::Estimate<double> fast;
  fast.x = {.position_m = 3.0, .velocity_m_s = 4.0};
  ref::Window<double> window = goal(2.0, 1.5);
  limiter.limit(window, fast, {}, {});
  EXPECT_TRUE(limiter.brakes());
  limiter.reset();
  window = goal(2.0, 1.5);
  limiter.limit(window, {}, {}, {});
  EXPECT_EQ(window.x[5].position_m, 2.0);
  EXPECT_EQ(window.x[5].velocity_m_s, 1.0);
  EXPECT_FALSE(limiter.brakes());
}

// Catches a box that walks: what one jump has cut off stays cut off.
TEST(GeofenceLimiter, OnlyNarrowsTheBox) {
  GeofenceLimiter<double> limiter(box(), shipped());
  const auto outside_m = [&](double x_m, double z_m) {
    est::Estimate<double> at;
    at.x.position_m = x_m;
    at.height_m = z_m;
    ref::Window<double> window = goal(0.0, 1.5);
    limiter.limit(window, at, {}, {});
    return limiter.outside_m();
  };
  core::Fence moved = box();
  moved.side[core::Fence::kX] = {-4, 6};
  limiter.intersect(moved);
  moved.side[core::Fence::kX] = {-6, 4};
  moved.side[core::Fence::kZ] = {1, 9};
  limiter.intersect(moved);
  limiter.intersect(box());
  EXPECT_NEAR(outside_m(4.5, 1.5), 0.5, 1e-9);
  EXPECT_NEAR(outside_m(-4.5, 1.5), 0.5, 1e-9);
  EXPECT_NEAR(outside_m(0.0, 0.8), 0.2, 1e-9);
  EXPECT_NEAR(outside_m(0.0, 4.2), 0.2, 1e-9);
}

// Catches a limiter that trusts a planned motion, or that plans its own stop, while the law flies by a false estimate:
// a pose scaled by 0.6 in a step of 2 m then took the aircraft 1.7 m past a side that was 1 m behind the goal.
TEST(GeofenceLimiter, AnAircraftThatFliesByADoubtfulEstimateIsStoppedByAGoalFarBehind) {
  GeofenceLimiter<double> limiter(box(), shipped());
  est::Estimate<double> known, flown_by;
  known.x = {.position_m = 2.2, .velocity_m_s = 4.0};
  flown_by.x = {.position_m = 1.3, .velocity_m_s = 2.4};
  const auto limited = [&](const est::Estimate<double>* by) {
    ref::Window<double> window;  // brakes by 4 m/s^2 from 4 m/s, which ends 0.8 m before the side
    for (std::size_t k = 0; k < window.x.size(); ++k) {
      const double t_s = 0.1 * static_cast<double>(k), braked_s = std::min(t_s, 1.0);
      window.x[k] = {2.2 + 4.0 * braked_s - 2.0 * braked_s * braked_s, 4.0 - 4.0 * braked_s, t_s < 1.0 ? -4.0 : 0.0};
    }
    limiter.limit(window, known, {}, {}, window.x.size(), by);
    return window;
  };
  EXPECT_EQ(limited(nullptr).x[0].position_m, 2.2) << "a motion that brakes in time is admitted";
  EXPECT_FALSE(limiter.brakes());
  EXPECT_NEAR(limited(&flown_by).x[5].position_m, 1.3 - 3.0, 1e-12);
  EXPECT_TRUE(limiter.brakes());
  known.x.velocity_m_s = 0.1;
  EXPECT_NEAR(limited(&flown_by).x[5].position_m, 1.3, 1e-12) << "slow enough: held where it is";
}

TEST(GeofenceLimiter, WithoutAFenceNothingIsHeld) {
  GeofenceLimiter<double> limiter{core::Fence{}, shipped()};
  ref::Window<double> window = goal(100.0, 50.0);
  est::Estimate<double> fast;
  fast.x.velocity_m_s = 8.0;
  limiter.limit(window, fast, {}, {});
  EXPECT_EQ(window.x[0].position_m, 100.0);
  EXPECT_FALSE(limiter.brakes());
}

TEST(GeofenceLimiter, SaysHowFarOutsideThePlaceIs) {
  GeofenceLimiter<double> limiter(box(), shipped());
  const auto outside = [&limiter](double x_m, double y_m, double z_m) {
    ref::Window<double> window = goal(0.0, 1.5);
    est::Estimate<double> estimate;
    estimate.x.position_m = x_m;
    estimate.y.position_m = y_m;
    estimate.height_m = z_m;
    limiter.limit(window, estimate, {}, {});
    return limiter.outside_m();
  };
  EXPECT_EQ(outside(0.0, 0.0, 1.5), -1.0);
  EXPECT_EQ(outside(0.0, -5.25, 1.5), 0.25);
  EXPECT_EQ(outside(5.5, 0.0, 1.5), 0.5);
  EXPECT_EQ(outside(0.0, 0.0, 0.25), 0.25);
  EXPECT_EQ(outside(0.0, 0.0, 4.5), 0.5);
}

/// An aircraft whose attitude follows the command after a delay (transport and command period).
struct Aircraft {
  const char* name;
  double natural_frequency_rad_s;
  double damping_ratio;
  double delay_s;
  double slope_limit;
  double lead_zero_s = 0.0;
};

Braking braking_of(const Aircraft& aircraft) {
  model::Vehicle vehicle = mpc::generated::kVehicle;
  for (model::StickAxis* const axis : {&vehicle.pitch, &vehicle.roll}) {
    axis->natural_frequency_rad_s = aircraft.natural_frequency_rad_s;
    axis->damping_ratio = aircraft.damping_ratio;
    axis->transport_delay_s = aircraft.delay_s;
    axis->lead_zero_s = aircraft.lead_zero_s;
  }
  return ctl::braking_of(vehicle, aircraft.slope_limit);
}

struct Start {
  double speed_m_s;
  double tilt_rad;
  double wind_m_s2;  ///< as estimated at the start: less the drag of the speed
  double drag_per_s;
};

/// Way to a stop with all the tilt that one axis is sure to have, with gusts of 30 % of 5 m/s in the worst phase.
double way_to_a_stop(const Aircraft& aircraft, const Start& start) {
  constexpr double kStep_s = 1e-3;
  const double w = aircraft.natural_frequency_rad_s, limit_rad = std::atan(aircraft.slope_limit);
  double x_m = 0.0, v = start.speed_m_s, angle = start.tilt_rad, rate = 0.0;
  for (double t_s = 0.0; v > 0.0 && t_s < 40.0; t_s += kStep_s) {
    const double wanted = t_s < aircraft.delay_s + 0.04 ? start.tilt_rad : -limit_rad;
    rate += kStep_s * (w * w * (wanted - angle) - 2.0 * aircraft.damping_ratio * w * rate);
    angle += kStep_s * rate;
    const double disturbance_acceleration_m_s2 = start.wind_m_s2 + start.drag_per_s * (start.speed_m_s - v);
    v += kStep_s * (9.8066 * std::tan(angle) + disturbance_acceleration_m_s2 + 0.3 * 0.3 * 5.0);
    x_m += kStep_s * v;
  }
  return x_m;
}

class EveryAircraft : public ::testing::TestWithParam<Aircraft> {};

/// Combinations of speed, tilt, wind and drag for which some tilt is left to brake with. Beyond them the failsafe acts
/// (the place cannot be held).
std::vector<Start> starts_of(const Aircraft& aircraft) {
  std::vector<Start> out;
  for (double speed = 0.5; speed <= 6.0; speed += 0.5) {
    for (const double tilt : {-1.0, 0.0, 0.5, 1.0}) {
      for (const double wind : {0.0, 0.75, 1.5}) {
        for (const double drag : {0.0, 0.15, 0.3}) {
          if (wind + 0.45 <= 0.9 * 9.8066 * aircraft.slope_limit) {
            out.push_back({speed, tilt * std::atan(aircraft.slope_limit), wind - drag * speed, drag});
          }
        }
      }
    }
  }
  return out;
}

// From every admitted state full braking must end inside the fence. Catches a reserve that ignores the way until the
// attitude has turned, the speed gained meanwhile, the wind, the drag that the speed hides in the wind estimate, or the
// parameters of the aircraft.
TEST_P(EveryAircraft, StopsInsideFromWhateverStateIsAdmitted) {
  RecordProperty("promise", "R16");
  const Aircraft& aircraft = GetParam();
  GeofenceLimiter<double> limiter(box(), braking_of(aircraft));
  int admitted = 0;
  for (const Start& start : starts_of(aircraft)) {
    est::Estimate<double> estimate;
    estimate.x = {.position_m = -4.0,
                  .velocity_m_s = start.speed_m_s,
                  .tilt_rad = start.tilt_rad,
                  .disturbance_m_s2 = start.wind_m_s2};
    ref::Window<double> window = goal(4.0, 1.5);
    window.x.fill({.position_m = 4.0});
    limiter.reset();
    limiter.limit(window, estimate, {}, {});
    if (limiter.reserve_m() < 0.0) {
      EXPECT_TRUE(limiter.brakes());
      EXPECT_LT(window.x[6].acceleration_m_s2, -0.5) << "a reference that brakes";
      continue;
    }
    ++admitted;
    EXPECT_LT(-4.0 + way_to_a_stop(aircraft, start), 5.0)
        << start.speed_m_s << " m/s, tilt " << start.tilt_rad << ", wind with the drag " << start.wind_m_s2 << ", drag "
        << start.drag_per_s;
  }
  EXPECT_GT(admitted, 30);
}

INSTANTIATE_TEST_SUITE_P(GeofenceLimiter, EveryAircraft,
                         ::testing::Values(Aircraft{"Shipped", 6.175, 0.712, 0.0553, 0.408, 0.149},
                                           Aircraft{"WithoutLead", 6.175, 0.712, 0.0553, 0.408},
                                           Aircraft{"OfLittleTilt", 6.175, 0.712, 0.0553, 0.2027},
                                           Aircraft{"OfALongDelay", 6.175, 0.712, 0.16, 0.408},
                                           Aircraft{"Slow", 3.0, 0.8, 0.1, 0.408}),
                         [](const auto& one) { return std::string(one.param.name); });

TEST(Settle, BrakesThenHoldsTrimAndWind) {
  for (const double sign : {1.0, -1.0}) {  // of x, and of y
    est::Estimate<double> estimate;
    estimate.prediction_valid = true;
    est::AxisEstimate<double>& axis = sign > 0.0 ? estimate.x : estimate.y;
    const auto tilt_rad = [&] {
      const Command<double> command = brake_and_hold(estimate, shipped());
      EXPECT_EQ(sign > 0.0 ? command.roll_rad : command.pitch_rad, 0.0);
      return sign > 0.0 ? command.pitch_rad : command.roll_rad;
    };
    const auto without_trim = [](double slope) { return slope - 0.02 * (1.0 + slope * slope); };
    axis = {.velocity_m_s = 4.0, .disturbance_m_s2 = 1.0, .input_offset_rad = 0.02, .velocity_variance_m2_s2 = 0.99};
    const double whole = without_trim(-sign * shipped().tilted_m_s2 / 9.8066);  // whatever the wind takes of it
    EXPECT_NEAR(tilt_rad(), std::atan(std::max(whole, -std::tan(std::numbers::pi / 6.0))), 1e-12);
    axis.velocity_m_s = 0.0;
    axis.tilt_rad = -sign / 9.8066;  // it holds against the wind: no acceleration
    EXPECT_NEAR(tilt_rad(), std::atan(without_trim(-sign / 9.8066)), 1e-12);
    axis.velocity_m_s = 4.0;
    axis.velocity_variance_m2_s2 = 1.0;  // a useless estimate
    EXPECT_NEAR(tilt_rad(), std::atan(without_trim(-sign / 9.8066)), 1e-12);
    estimate.prediction_valid = false;
    EXPECT_EQ(tilt_rad(), 0.0);
  }
}

// Catches a LEVEL state that needs more way to a stop than the fence predicts plus the 0.4 m by which the fence brakes
// early, or that swings back.
TEST_P(EveryAircraft, SettlesWithinTheWayThatTheFenceReckonsWith) {
  RecordProperty("promise", "R16");
  const Aircraft& aircraft = GetParam();
  const Braking braking = braking_of(aircraft);
  GeofenceLimiter<double> limiter(box(), braking);
  const double w = aircraft.natural_frequency_rad_s;
  for (const double speed : {1.0, 2.0, 4.0}) {
    est::Estimate<double> estimate;
    estimate.prediction_valid = true;
    estimate.x = {.position_m = -4.0, .velocity_m_s = speed, .velocity_variance_m2_s2 = 0.01};
    ref::Window<double> window = goal(4.0, 1.5);
    limiter.limit(window, estimate, {}, {});
    const double ends_m = 5.0 - limiter.reserve_m();
    std::deque<double> pipe(static_cast<std::size_t>(aircraft.delay_s * 1e3), 0.0);
    double angle = 0.0, rate = 0.0, least_m_s = speed;
    for (int k = 0; k < 8000; ++k) {
      pipe.push_back(k % 40 == 0 ? brake_and_hold(estimate, braking).pitch_rad : pipe.back());
      rate += 1e-3 * (w * w * (pipe.front() - angle) - 2.0 * aircraft.damping_ratio * w * rate);
      pipe.pop_front();
      angle += 1e-3 * rate;
      const double tilt_before_rad = estimate.x.tilt_rad;
      estimate.x.tilt_rad = angle + aircraft.lead_zero_s * rate;
      estimate.x.tilt_rate_rad_s = 1e3 * (estimate.x.tilt_rad - tilt_before_rad);
      estimate.x.velocity_m_s += 1e-3 * 9.8066 * std::tan(estimate.x.tilt_rad);
      estimate.x.position_m += 1e-3 * estimate.x.velocity_m_s;
      least_m_s = std::min(least_m_s, estimate.x.velocity_m_s);
    }
    EXPECT_LT(estimate.x.position_m, ends_m + 0.4) << speed << " m/s";
    EXPECT_NEAR(estimate.x.velocity_m_s, 0.0, 0.05) << speed << " m/s";
    EXPECT_GT(least_m_s, -0.15) << speed << " m/s";
  }
}

// Catches a law that eases the brakes at twice the speed: linear, a stop from 2 m/s took 1.72 m instead of 1.59 m.
TEST(Settle, BrakesFullyDownToHalfTheSpeedOfALinearLaw) {
  RecordProperty("promise", "R16");
  const double braking = shipped().tilted_m_s2;
  const double full_m_s = braking * shipped().lag_s / (2.0 * 0.7);
  est::Estimate<double> estimate;
  estimate.prediction_valid = true;
  for (const double speed : {1.01, -1.01}) {
    estimate.x = {.velocity_m_s = speed * full_m_s, .velocity_variance_m2_s2 = 0.01};
    EXPECT_NEAR(brake_and_hold(estimate, shipped()).pitch_rad, std::atan(std::copysign(braking, -speed) / 9.8066),
                1e-9);
  }
  estimate.x.velocity_m_s = 0.5 * full_m_s;
  EXPECT_NEAR(brake_and_hold(estimate, shipped()).pitch_rad, std::atan(-0.3125 * braking / 9.8066), 1e-9);
}

}  // namespace
}  // namespace m100::ctl
