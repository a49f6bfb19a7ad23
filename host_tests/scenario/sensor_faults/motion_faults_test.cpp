// SPDX-License-Identifier: BSD-3-Clause
// A pose that goes wrong during a step, in flights of the whole controller (promises R14 and R16): the fence lies one
// metre beyond the course, and the fault begins at any moment of the step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/experiments/flight.h"
#include "host_tests/sim/sensor_faults/sensor_fault_injector.h"

namespace m100::scenario {
namespace {

using sim::PoseSample;
using Memory = sim::SensorFaultState<PoseSample>;

/// Follows the true place with a time constant of `size` seconds.
void low_pass(PoseSample& sample, Memory& memory, double size) {
  if (memory.kept.empty()) {
    memory.kept.push_back(*memory.first);
  }
  PoseSample& last = memory.kept.back();
  const double passed_s = core::seconds<double>(sample.captured - last.captured);
  last.position_w_m += (sample.position_w_m - last.position_w_m) * std::min(passed_s / size, 1.0);
  last.captured = sample.captured;
  sample.position_w_m = last.position_w_m;
}

/// The place in the world times `size`; at the centre of the fence this is no jump.
void scale(PoseSample& sample, Memory& memory, double size) {
  sample.position_w_m.head<2>() =
      memory.first->position_w_m.head<2>() + size * (sample.position_w_m - memory.first->position_w_m).head<2>();
}

constexpr sim::SensorFault kLowPass{"low_pass", "low-passed place", 0.2, "s", low_pass};
constexpr sim::SensorFault kScaled{"scaled", "scaled place", 0.6, "", scale};

struct MotionFaultCase {
  const char* name;
  const sim::SensorFault* fault;
  double size;
  double from_s;  ///< after the beginning of the step, which is 2 m long; negative: before it
  link::Channel channel;
};

struct MotionOutcome {
  double farthest_m = 0.0;
  double handed_over_m_s = 0.0;
  bool handed_over = false;
};

constexpr double kStepAt_s = 8.0, kFence_m = 3.0;

MotionOutcome flown(const MotionFaultCase& fault, int seed) {
  lab::experiments::FlightPlan plan;
  plan.plant = sim::measured_plant();
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  plan.course = "step 0 0 0 0 8\nstep 2 0 0 0 6\nstep 2 2 0 0 6\nstep 0 2 0 0 6\nstep 0 0 0 0 6\n";
  plan.duration_s = 26.0;
  plan.seed = static_cast<std::uint64_t>(seed);
  plan.channel = fault.channel;
  plan.pilot_holds_position = true;
  plan.flight_file = companion::parse_flight(
      "[fence]\nx_m = [-3, 3]\ny_m = [-3, 3]\nz_m = [0.3, 4]\n[wind]\nclass_m_s = 5\n", "flight.toml");
  plan.disturb = [&, struck = false](sim::World& world, double t_s) mutable {
    if (!struck && t_s >= kStepAt_s + fault.from_s) {
      struck = true;
      world.fault(*fault.fault, fault.size);
    }
  };
  const lab::experiments::FlightResult result = lab::experiments::fly(plan);
  MotionOutcome outcome;
  bool left = false;
  for (const lab::experiments::TracePoint& point : result.trace) {
    const auto& start = result.trace.front().position_m;
    outcome.farthest_m = std::max(
        {outcome.farthest_m, std::abs(point.position_m[0] - start[0]), std::abs(point.position_m[1] - start[1])});
    outcome.handed_over_m_s = std::hypot(point.velocity_m_s[0], point.velocity_m_s[1]);
    left = left || point.failsafe_state == static_cast<int>(safety::FailsafeState::kLevel);
    if (left && point.failsafe_state == static_cast<int>(safety::FailsafeState::kSilent)) {
      outcome.handed_over = true;
      break;
    }
  }
  return outcome;
}

constexpr auto kRc = link::Channel::kVirtualRc;
constexpr auto kMovement = link::Channel::kMovement;
const MotionFaultCase kCases[] = {
    {"stands_before", sim::find_sensor_fault("standing"), 0.0, -1.2, kRc},
    {"stands_before_movement", sim::find_sensor_fault("standing"), 0.0, -1.2, kMovement},
    {"stands_at_once", sim::find_sensor_fault("standing"), 0.0, 0.0, kRc},
    {"stands_in_it", sim::find_sensor_fault("standing"), 0.0, 0.4, kRc},
    {"scaled_before", &kScaled, 0.6, -1.2, kRc},
    {"scaled_before_movement", &kScaled, 0.6, -1.2, kMovement},
    {"scaled_in_it", &kScaled, 0.6, 0.3, kRc},
    {"low_pass_before", &kLowPass, 0.2, -1.2, kRc},
    {"low_pass_before_movement", &kLowPass, 0.2, -1.2, kMovement},
    {"low_pass_in_it", &kLowPass, 0.2, 0.3, kRc},
    {"mirror_before", sim::find_sensor_fault("mirror"), 0.0, 4.8, kRc},
    // The autopilot's attitude: the poses are right, and with our commands they show the speed.
    {"rates_swapped_at_rest", sim::find_sensor_fault("rates_swapped"), 0.0, -0.1, kRc},
    {"attitude_stutters_at_rest", sim::find_sensor_fault("attitude_stutters"), 0.4, -0.4, kMovement},
    {"tilt_rates_swapped_in_it", sim::find_sensor_fault("tilt_rates_swapped"), 0.0, 0.05, kRc},
    {"rates_not_numbers_in_it", sim::find_sensor_fault("rates_nan"), 0.0, 0.2, kRc},
    {"attitude_too_long_in_it", sim::find_sensor_fault("attitude_length"), 1.7, 0.9, kRc},
};

class MotionFault : public ::testing::TestWithParam<MotionFaultCase> {};

TEST_P(MotionFault, StaysInsideTheFenceAndIsHandedOverSlowly) {
  RecordProperty("promise", "R14");
  for (int seed = 1; seed <= 2; ++seed) {
    const MotionOutcome outcome = flown(GetParam(), seed);
    std::printf("%s %d: far %.2f m, %s at %.2f m/s\n", GetParam().name, seed, outcome.farthest_m,
                outcome.handed_over ? "handed over" : "kept", outcome.handed_over_m_s);
    EXPECT_LT(outcome.farthest_m, kFence_m + 0.3) << "seed " << seed;
    EXPECT_TRUE(!outcome.handed_over || outcome.handed_over_m_s < 1.0) << outcome.handed_over_m_s;
  }
}
INSTANTIATE_TEST_SUITE_P(SensorFaults, MotionFault, ::testing::ValuesIn(kCases),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace m100::scenario
