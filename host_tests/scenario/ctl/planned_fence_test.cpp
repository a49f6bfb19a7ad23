// SPDX-License-Identifier: BSD-3-Clause
// A set point beside a side of the fence, with planner, limiter and law in a closed loop: the plan brakes in time, so
// that the limiter has nothing to stop, and the command turns as often as without a fence.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <random>
#include <vector>

#include "firmware/ctl/law/flight_law.h"
#include "firmware/mpc/generated/gain_table.h"

namespace m100::ctl {
namespace {

constexpr double kFar_m = 60.0;
constexpr double kDrag_per_s = 0.3;
constexpr double kWindClass_m_s = 5.0;
constexpr double kStepAt_s = 2.0;

struct Approach {
  double behind_m = kFar_m;  ///< from the goal to the side
  double wind_m_s = 0.0;     ///< towards the side
  double gust_m_s = 0.0;     ///< one sigma, correlated over 1 s
  double step_m = 6.0;
  double gain = 1.0;  ///< of the tilt, which the vehicle file does not know
  unsigned seed = 1;
};

struct Flown {
  int turns = 0;            ///< of the pitch command, by more than 20 degrees
  double settled_s = 0.0;   ///< until the distance from the goal stays below 2 % of the step
  double farthest_m = 0.0;  ///< beyond the goal
  std::uint32_t stops = 0;
  double between_s = 1e9;  ///< the shortest time between the beginnings of two stops
};

int turns_of(const std::vector<double>& command_rad) {
  constexpr double kTurn_rad = 0.35;
  int turns = 0, direction = 0;
  double low = command_rad.front(), high = low;
  for (const double value : command_rad) {
    low = direction > 0 ? low : std::min(low, value);
    high = direction < 0 ? high : std::max(high, value);
    if (direction >= 0 && value < high - kTurn_rad) {
      turns += direction > 0 ? 1 : 0;
      direction = -1;
      low = value;
    } else if (direction <= 0 && value > low + kTurn_rad) {
      turns += direction < 0 ? 1 : 0;
      direction = 1;
      high = value;
    }
  }
  return turns;
}

/// One axis of the shipped vehicle: delay, attitude loop, drag in wind and gusts, an estimate with a little noise.
class Aircraft {
 public:
  explicit Aircraft(const Approach& approach) : approach_(approach), random_(approach.seed) {
    state_.tilt_rad = -std::atan(drag_per_s() * approach.wind_m_s / model::kGravity_m_s2);
    state_.disturbance_m_s2 = drag_per_s() * approach.wind_m_s;
    state_.position_variance_m2 = 1e-4;
    pipe_.assign(static_cast<std::size_t>(axis_.transport_delay_s / kStep_s), state_.tilt_rad);
  }
  const est::AxisEstimate<double>& truth() const { return state_; }
  est::AxisEstimate<double> estimate() {
    est::AxisEstimate<double> seen = state_;
    seen.position_m += 0.003 * normal_(random_);
    seen.velocity_m_s += 0.02 * normal_(random_);
    return seen;
  }
  void fly(double command_rad) {
    const double w = axis_.natural_frequency_rad_s;
    for (int i = 0; i < 10; ++i) {
      pipe_.push_back(approach_.gain * command_rad);
      state_.tilt_rate_rad_s += kStep_s * (w * w * (pipe_.front() - state_.tilt_rad) -
                                           2.0 * axis_.damping_ratio * w * state_.tilt_rate_rad_s);
      pipe_.pop_front();
      state_.tilt_rad += kStep_s * state_.tilt_rate_rad_s;
      gust_m_s_ += -kStep_s * gust_m_s_ + approach_.gust_m_s * std::sqrt(2.0 * kStep_s) * normal_(random_);
      const double pushed_m_s2 = drag_per_s() * (approach_.wind_m_s + gust_m_s_ - state_.velocity_m_s);
      state_.velocity_m_s += kStep_s * (model::kGravity_m_s2 * std::tan(state_.tilt_rad) + pushed_m_s2);
      state_.position_m += kStep_s * state_.velocity_m_s;
      state_.disturbance_m_s2 += kStep_s / kObserver_s * (pushed_m_s2 - state_.disturbance_m_s2);
    }
  }

 private:
  static constexpr double kStep_s = 1e-3;
  static constexpr double kObserver_s = 0.3;
  double drag_per_s() const { return approach_.wind_m_s > 0.0 ? kDrag_per_s : 0.05; }

  Approach approach_;
  model::StickAxis axis_ = mpc::generated::kVehicle.pitch;
  est::AxisEstimate<double> state_;
  std::deque<double> pipe_;
  double gust_m_s_ = 0.0;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

Flown fly(const Approach& approach) {
  const mpc::GainTables<double> tables{.x = mpc::generated::kX<double>, .y = mpc::generated::kY<double>};
  FlightLaw<double> law(mpc::generated::kVehicle, tables);
  core::Fence box{.wind_m_s = kWindClass_m_s};
  box.side[core::Fence::kX].high_m = approach.step_m + approach.behind_m;
  GeofenceLimiter<double> fence(box, braking_of(mpc::generated::kVehicle, law.slope_limit()));
  Aircraft aircraft(approach);
  Command<double> applied{.pitch_rad = aircraft.truth().tilt_rad};
  std::vector<double> command_rad;
  Flown flown;
  double stop_began_s = -1e9;
  for (int tick = 0; tick < 1400; ++tick) {
    const double time_s = 0.01 * tick;
    const core::TimePoint now{std::chrono::milliseconds(10 * tick)};
    est::Estimate<double> estimate;
    estimate.prediction_valid = estimate.healthy = true;
    estimate.x = aircraft.estimate();
    ref::Window<double> window{.constant = true};
    window.x.fill({.position_m = time_s < kStepAt_s ? 0.0 : approach.step_m});
    law.plan(window, estimate, fence, now, window.x.size());
    fence.limit(window, estimate, now, law.lead());
    const Command<double> wanted = law.update(estimate, window, applied, core::kTickPeriod);
    applied = tick % 4 == 0 ? Command<double>{.pitch_rad = wanted.pitch_rad} : applied;
    aircraft.fly(applied.pitch_rad);
    command_rad.push_back(applied.pitch_rad);
    if (fence.status().stops > flown.stops) {
      flown.between_s = std::min(flown.between_s, time_s - stop_began_s);
      stop_began_s = time_s;
      flown.stops = fence.status().stops;
    }
    const double beyond_m = aircraft.truth().position_m - approach.step_m;
    flown.farthest_m = tick == 0 ? beyond_m : std::max(flown.farthest_m, beyond_m);
    flown.settled_s = std::abs(beyond_m) > 0.02 * approach.step_m ? time_s - kStepAt_s : flown.settled_s;
  }
  flown.turns = turns_of(command_rad);
  return flown;
}

// Catches a fence that brakes by its present stopping distance what was planned without it: the command turned up to 21
// times. The planner may brake less, so a step beside a side takes longer.
TEST(PlannedFence, TheCommandTurnsThreeTimesAndTheStepIsHardlySlower) {
  for (const double wind_m_s : {0.0, kWindClass_m_s}) {
    const Flown free = fly({.wind_m_s = wind_m_s});
    for (const double behind_m : {4.0, 2.0, 1.0, 0.5, 0.2}) {
      const Flown flown = fly({.behind_m = behind_m, .wind_m_s = wind_m_s});
      EXPECT_LE(flown.turns, 3) << behind_m << " m, wind " << wind_m_s;
      EXPECT_EQ(flown.stops, 0U) << behind_m << " m, wind " << wind_m_s;
      EXPECT_LT(flown.farthest_m, behind_m);
      if (behind_m >= 0.5) {
        EXPECT_LE(flown.settled_s, (wind_m_s > 0.0 ? 1.6 : 1.3) * free.settled_s) << behind_m << " m, " << wind_m_s;
      }
    }
  }
}

// Catches a plan that leaves the limiter no margin for the aircraft's own deviation: 1 000 calm flights of drawn steps,
// gains and distances to the side, not one stop.
TEST(PlannedFence, InCalmTheLimiterNeverStopsAPlannedMotion) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> behind_m(0.2, 3.0), step_m(0.5, 20.0), gain(0.9, 1.1);
  int stopped = 0;
  for (unsigned seed = 0; seed < 1000; ++seed) {
    const Approach approach{.behind_m = behind_m(random), .step_m = step_m(random), .gain = gain(random), .seed = seed};
    const Flown flown = fly(approach);
    stopped += flown.stops > 0 ? 1 : 0;
    EXPECT_LT(flown.farthest_m, approach.behind_m);
  }
  EXPECT_EQ(stopped, 0);
}

// In gusts of the class the limiter may have to stop the aircraft; one stop is then one stop.
TEST(PlannedFence, InGustsStopsAreAtLeastASecondApart) {
  std::uint32_t stops = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    const Flown flown =
        fly({.behind_m = 0.2, .wind_m_s = kWindClass_m_s, .gust_m_s = 0.3 * kWindClass_m_s, .seed = seed});
    EXPECT_GE(flown.between_s, 1.0);
    EXPECT_LT(flown.farthest_m, 0.2);
    stops += flown.stops;
  }
  EXPECT_GT(stops, 0U) << "nothing was tested";
  RecordProperty("stops", static_cast<int>(stops));
}

}  // namespace
}  // namespace m100::ctl
