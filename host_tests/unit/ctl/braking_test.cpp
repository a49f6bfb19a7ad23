// SPDX-License-Identifier: BSD-3-Clause
// How a vehicle can brake, by the formulas of the header, with numbers worked out by hand. The fence, the LEVEL state
// and the speed limit use them.
#include "firmware/ctl/law/braking.h"

#include <gtest/gtest.h>

namespace m100::ctl {
namespace {

constexpr double kExact = 1e-12;

model::StickAxis lagging(double delay_s, double time_constant_s) {
  model::StickAxis axis;
  axis.transport_delay_s = delay_s;
  axis.time_constant_s = time_constant_s;
  axis.natural_frequency_rad_s = 0.0;
  return axis;
}
model::StickAxis swinging(double delay_s, double frequency_rad_s, double damping) {
  model::StickAxis axis;
  axis.transport_delay_s = delay_s;
  axis.natural_frequency_rad_s = frequency_rad_s;
  axis.damping_ratio = damping;
  return axis;
}
model::Vehicle vehicle_of(const model::StickAxis& roll, const model::StickAxis& pitch) {
  model::Vehicle vehicle;
  vehicle.roll = roll;
  vehicle.pitch = pitch;
  vehicle.translation.tilt_gain = 1.0;
  vehicle.translation.linear_drag_per_s = 0.0;
  return vehicle;
}

TEST(Braking, TheReactionIsThatOfTheSlowerAxis) {
  const model::StickAxis quick = swinging(0.05, 10.0, 0.5);  // 0.05 + 0.1
  const model::StickAxis slow = swinging(0.10, 5.0, 0.75);   // 0.10 + 0.3
  const model::StickAxis slower = lagging(0.20, 0.3);        // 0.20 + 0.3
  ASSERT_TRUE(slower.is_first_order());
  EXPECT_NEAR(braking_of(vehicle_of(quick, slow), 0.3).reaction_s, 0.40 + 0.04 + 0.02, kExact);
  EXPECT_NEAR(braking_of(vehicle_of(slow, quick), 0.3).reaction_s, 0.40 + 0.04 + 0.02, kExact);
  EXPECT_NEAR(braking_of(vehicle_of(slower, slow), 0.3).reaction_s, 0.50 + 0.04 + 0.02, kExact);
  EXPECT_EQ(braking_of(vehicle_of(quick, quick), 0.3).reaction_s, 0.35) << "never quicker";
  EXPECT_EQ(braking_of(vehicle_of({}, {}), 0.3).reaction_s, 0.35) << "no lag is known";
}

// Catches a look-ahead that leaves out the lead of the attitude loop, as a constant of 0.35 s did.
TEST(Braking, TheLagIsTheDelayAndTheInverseOfTheSlowerLoop) {
  model::StickAxis led = swinging(0.05, 5.0, 0.75);  // 2 zeta / w = 0.3 s, 1 / w^2 = 0.04 s^2
  led.lead_zero_s = 0.1;
  const Braking braking = braking_of(vehicle_of(swinging(0.05, 10.0, 0.5), led), 0.3);
  EXPECT_NEAR(braking.lag_s, 0.05 + 0.3 - 0.1, kExact);
  EXPECT_NEAR(braking.lag2_s2, 0.04 - 0.1 * (0.3 - 0.1), kExact);
  EXPECT_NEAR(braking.reaction_s, 0.05 + 0.3 + 0.04 + 0.02, kExact) << "the fence does without the lead";
  EXPECT_EQ(braking_of(vehicle_of({}, {}), 0.3).lag_s, 0.1) << "no lag is known";
}

TEST(Braking, ACommandActsAfterDelayAndPeriod) {
  EXPECT_NEAR(effective_delay_s(lagging(0.12, 0.3)), 0.16, kExact);
  const model::Vehicle vehicle = vehicle_of(lagging(0.12, 0.1), swinging(0.07, 3.0, 1.0));
  EXPECT_NEAR(braking_of(vehicle, 0.3).acts_s, 0.16, kExact);
  const model::Vehicle turned = vehicle_of(vehicle.pitch, vehicle.roll);
  EXPECT_NEAR(braking_of(turned, 0.3).acts_s, 0.16, kExact);
}

TEST(Braking, WhatTheLawGivesIsTakenATwentiethLess) {
  model::Vehicle vehicle = vehicle_of(lagging(0.1, 0.1), lagging(0.1, 0.1));
  EXPECT_NEAR(braking_of(vehicle, 0.2).acceleration_m_s2, 0.95 * model::kGravity_m_s2 * 0.2, kExact);
  EXPECT_NEAR(braking_of(vehicle, 0.2).max_disturbance_m_s2, 0.95 * model::kGravity_m_s2 * 0.2, kExact);
  vehicle.translation.tilt_gain = 0.8;
  EXPECT_NEAR(braking_of(vehicle, 0.2).acceleration_m_s2, 0.8 * 0.95 * model::kGravity_m_s2 * 0.2, kExact);
  EXPECT_NEAR(braking_of(vehicle, 1.0).acceleration_m_s2, 0.8 * 0.95 * model::kGravity_m_s2, kExact);
  EXPECT_EQ(braking_of(vehicle, 1.0).max_disturbance_m_s2, 4.0) << "no more, however strong it is";
}

TEST(Braking, AVehicleFileMayBelieveTooLittleDrag) {
  model::Vehicle vehicle = vehicle_of(lagging(0.1, 0.1), lagging(0.1, 0.1));
  EXPECT_NEAR(braking_of(vehicle, 0.2).unknown_drag_per_s, 0.3, kExact);
  EXPECT_NEAR(braking_of(vehicle, 0.2).drag_per_s, 0.3, kExact);
  vehicle.translation.linear_drag_per_s = 0.1;
  EXPECT_NEAR(braking_of(vehicle, 0.2).unknown_drag_per_s, 0.2, kExact);
  EXPECT_NEAR(braking_of(vehicle, 0.2).drag_per_s, 0.3, kExact);
  vehicle.translation.linear_drag_per_s = 0.45;
  EXPECT_EQ(braking_of(vehicle, 0.2).unknown_drag_per_s, 0.0);
  EXPECT_NEAR(braking_of(vehicle, 0.2).drag_per_s, 0.45, kExact);
}

}  // namespace
}  // namespace m100::ctl
