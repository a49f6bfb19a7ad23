// SPDX-License-Identifier: BSD-3-Clause
// A pose that goes wrong during a step, in flights of the whole controller (promises R14 and R16): the fence lies one
// metre beyond the course, and the fault begins at any moment of the step.
#include <gtest/gtest.h>

#include <cstdio>

#include "host_tests/scenario/sensor_faults/motion_fault_bench.h"

namespace m100::scenario {
namespace {

/// The place in the world times `size`; at the centre of the fence this is no jump.
void scale(sim::PoseSample& sample, sim::SensorFaultState<sim::PoseSample>& memory, double size) {
  sample.position_w_m.head<2>() =
      memory.first->position_w_m.head<2>() + size * (sample.position_w_m - memory.first->position_w_m).head<2>();
}

constexpr sim::SensorFault kScaled{"scaled", "scaled place", 0.6, "", scale};

struct MotionFaultCase {
  const char* name;
  const sim::SensorFault* fault;
  double size;
  double from_s;  ///< after the beginning of the step; negative: before it
  link::Channel channel;
};

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
    {"tilt_jumps_in_the_next_one", sim::find_sensor_fault("tilt_offset"), 7.21, 6.68, kRc},
};

class MotionFault : public ::testing::TestWithParam<MotionFaultCase> {};

TEST_P(MotionFault, StaysInsideTheFenceAndIsHandedOverSlowly) {
  RecordProperty("promise", "R14");
  const MotionFaultCase& fault = GetParam();
  for (int seed = 1; seed <= 2; ++seed) {
    const MotionOutcome outcome = outcome_of({fault.fault, fault.size, kStepAt_s + fault.from_s, fault.channel, seed});
    std::printf("%s %d: %.2f m beyond the fence, %s at %.2f m/s\n", fault.name, seed, outcome.beyond_m,
                outcome.handed_over ? "handed over" : "kept", outcome.handed_over_m_s);
    EXPECT_LT(outcome.beyond_m, 0.3) << "seed " << seed;
    EXPECT_TRUE(!outcome.handed_over || outcome.handed_over_m_s < 1.0) << outcome.handed_over_m_s;
  }
}
INSTANTIATE_TEST_SUITE_P(SensorFaults, MotionFault, ::testing::ValuesIn(kCases),
                         [](const auto& tested) { return std::string(tested.param.name); });

// Catches a refused heading that is adopted while the aircraft brakes by it. soak.motion_faults flies 60 of them.
TEST(TurnedHeading, StaysInsideTheFenceAndIsHandedOverSlowly) {
  RecordProperty("promise", "R14");
  const MotionWorst worst = worst_of_headings(12, 52);
  EXPECT_LT(worst.beyond_m, 0.3);
  EXPECT_LT(worst.handed_over_m_s, 1.0);
}

// Catches a turn that is reckoned by the autopilot's clock.
TEST(SlowClock, InATurnStaysInsideTheFenceAndIsHandedOverSlowly) {
  RecordProperty("promise", "R14");
  for (const double at_s : {23.3, 26.7}) {
    const MotionOutcome outcome = outcome_of(
        {.fault = sim::find_sensor_fault("clock_slow"), .size = 0.14, .at_s = at_s, .course = kStepsAndTurns});
    EXPECT_LT(outcome.beyond_m, 0.3) << at_s;
    EXPECT_LT(outcome.handed_over_m_s, 1.0) << at_s;
  }
}

// Catches braking by an attitude that drifted away slowly. soak.motion_faults flies 60 of them.
TEST(DriftingTilt, StaysInsideTheFenceAndIsHandedOverSlowly) {
  RecordProperty("promise", "R14");
  const MotionWorst worst = worst_of_tilts(12, 52);
  EXPECT_GT(worst.handed_over, worst.flights / 2) << "small ones are flown on as a wind";
  EXPECT_LT(worst.beyond_m, 0.3);
  EXPECT_LT(worst.handed_over_m_s, 1.0);
}

}  // namespace
}  // namespace m100::scenario
