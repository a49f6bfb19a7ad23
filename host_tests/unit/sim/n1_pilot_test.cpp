// SPDX-License-Identifier: BSD-3-Clause
// The simulated pilot of the emulated autopilot. Tests that judge where an aircraft goes after its release rely on him.
#include <gtest/gtest.h>

#include <algorithm>

#include "host_tests/sim/autopilot/n1_pilot.h"
#include "host_tests/sim/world/plant.h"
#include "host_tests/sim/world/vehicle.h"

namespace m100::sim {
namespace {

constexpr core::Duration kStep = std::chrono::microseconds(2500);

struct Air {
  const char* name;
  double drag_per_s;
  double wind_m_s;
  double turbulence_m_s;
};
class PilotIn : public ::testing::TestWithParam<Air> {};
// Calm, a breeze, and the strongest promised wind (R12), the last two with realistic drag.
INSTANTIATE_TEST_SUITE_P(N1Pilot, PilotIn,
                         ::testing::Values(Air{"Calm", 0.0144, 0.0, 0.0}, Air{"Breeze", 0.3, 5.0, 0.5},
                                           Air{"Storm", 0.3, 12.0, 1.2}),
                         [](const auto& tested) { return tested.param.name; });

Plant plant_of(const Air& air) {
  Plant plant = measured_plant();
  plant.air.linear_drag_per_s = air.drag_per_s;
  plant.air.wind_m_s.x() = air.wind_m_s;
  plant.air.turbulence_m_s = air.turbulence_m_s;
  return plant;
}

StickInput balance(const Plant& plant) {
  return {.roll_vrc = 1024.0 + plant.roll.trim_counts, .pitch_vrc = 1024.0 + plant.pitch.trim_counts};
}

TEST_P(PilotIn, HoldsThePlaceWithinAMetre) {
  const Plant plant = plant_of(GetParam());
  Vehicle vehicle(plant, 3, {0.0, 0.0, 1.5});
  N1Pilot pilot;
  pilot.set_resting(balance(plant));
  double farthest_m = 0.0;
  for (core::Duration time{0}; time < std::chrono::seconds(60); time += kStep) {
    vehicle.command(pilot.fly(vehicle.state(), kStep));
    vehicle.advance(kStep);
    const core::Vector<double, 3> away_m = vehicle.state().position_w_m - core::Vector<double, 3>(0.0, 0.0, 1.5);
    farthest_m = std::max(farthest_m, away_m.norm());
  }
  RecordProperty("farthest_m", std::to_string(farthest_m));
  EXPECT_LT(farthest_m, 1.0);
}

TEST_P(PilotIn, BrakesAnAircraftThatComesToHimMovingAndHoldsWhereItStopped) {
  const Plant plant = plant_of(GetParam());
  Vehicle vehicle(plant, 3, {0.0, 0.0, 1.5});
  for (core::Duration time{0}; time < std::chrono::milliseconds(1500); time += kStep) {
    vehicle.command(MovementInput{.roll_rad = 0.3});
    vehicle.advance(kStep);
  }
  N1Pilot pilot;
  pilot.set_resting(balance(plant));
  const auto fly = [&](std::chrono::seconds time) {
    for (core::Duration passed{0}; passed < time; passed += kStep) {
      vehicle.command(pilot.fly(vehicle.state(), kStep));
      vehicle.advance(kStep);
    }
  };
  fly(std::chrono::seconds(6));
  const core::Vector<double, 3> place = vehicle.state().position_w_m;
  double farthest_m = 0.0;
  for (int second = 0; second < 30; ++second) {
    fly(std::chrono::seconds(1));
    farthest_m = std::max(farthest_m, (vehicle.state().position_w_m - place).norm());
  }
  EXPECT_LT(farthest_m, 1.0);
}

}  // namespace
}  // namespace m100::sim
