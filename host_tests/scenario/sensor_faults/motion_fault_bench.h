// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "host_tests/scenario/sensor_faults/sensor_fault_bench.h"

namespace m100::scenario {

/// Follows the true place with a time constant of `size` seconds.
inline void low_pass(sim::PoseSample& sample, sim::SensorFaultState<sim::PoseSample>& memory, double size) {
  if (memory.kept.empty()) {
    memory.kept.push_back(*memory.first);
  }
  sim::PoseSample& last = memory.kept.back();
  const double passed_s = core::seconds<double>(sample.captured - last.captured);
  last.position_w_m += (sample.position_w_m - last.position_w_m) * std::min(passed_s / size, 1.0);
  last.captured = sample.captured;
  sample.position_w_m = last.position_w_m;
}

inline constexpr sim::SensorFault kLowPass{"low_pass", "low-passed place", 0.2, "s", low_pass};

/// One flight on a square of 2 m whose first step begins at kStepAt_s; the fence lies one metre beyond it.
struct MotionFlight {
  const sim::SensorFault* fault = nullptr;
  double size = 0.0;
  double at_s = 0.0;
  link::Channel channel = link::Channel::kVirtualRc;
  int seed = 1;
  Air air = Air::kCalm;
};

struct MotionOutcome {
  double beyond_m = -1e3;  ///< the fence, at most; negative: inside
  double handed_over_m_s = 0.0;
  bool handed_over = false;
};

inline constexpr double kStepAt_s = 8.0;

inline MotionOutcome outcome_of(const MotionFlight& flight) {
  lab::experiments::FlightPlan plan = plan_in(flight.air, flight.seed);
  plan.course = "step 0 0 0 0 8\nstep 2 0 0 0 6\nstep 2 2 0 0 6\nstep 0 2 0.4 0 6\nstep 0 0 0 0 6\n";
  plan.duration_s = 36.0;
  plan.channel = flight.channel;
  plan.flight_file = companion::parse_flight(
      "[fence]\nx_m = [-1, 3]\ny_m = [-1, 3]\nz_m = [0.3, 3]\n[wind]\nclass_m_s = 5\n", "flight.toml");
  plan.disturb = strikes_at(flight.at_s, *flight.fault, flight.size);
  const lab::experiments::FlightResult result = lab::experiments::fly(plan);
  MotionOutcome outcome;
  for (const lab::experiments::TracePoint& point : result.trace) {
    const double x_m = point.position_m[0] - result.start.position_w_m.x();
    const double y_m = point.position_m[1] - result.start.position_w_m.y();
    outcome.beyond_m = std::max({outcome.beyond_m, std::abs(x_m - 1.0) - 2.0, std::abs(y_m - 1.0) - 2.0,
                                 std::abs(point.position_m[2] - 1.65) - 1.35});
    outcome.handed_over_m_s = std::hypot(point.velocity_m_s[0], point.velocity_m_s[1]);
    outcome.handed_over =
        point.t_s > flight.at_s && point.failsafe_state == static_cast<int>(safety::FailsafeState::kSilent);
    if (outcome.handed_over) {
      break;
    }
  }
  return outcome;
}

}  // namespace m100::scenario
