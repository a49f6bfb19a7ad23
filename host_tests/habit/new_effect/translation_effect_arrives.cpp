// SPDX-License-Identifier: BSD-3-Clause
// Checks that the table, the files and the simulated aircraft know the added effect. Compiled in the copy that
// new_effect.py makes. Identification and report read the same table; the whole form of the test covers them.
#include <chrono>
#include <cmath>
#include <cstdio>

#include "firmware/companion/files/vehicle_keys.h"
#include "firmware/model/translation.h"
#include "host_tests/sim/world/vehicle.h"

using namespace m100;  // Deviation: a test program of one page.

int main() {
  constexpr double kRate_per_s = 0.3;
  constexpr double kWind_m_s = 5.0;
  const model::TranslationEffect* effect = model::translation_effect("side_force");
  if (effect == nullptr || effect->sentence.empty()) {
    std::puts("the table of effects does not have the effect");
    return 2;
  }
  const auto keys = companion::translation_keys();
  if (keys.back().key != "side_force_per_s" || !keys.back().only_if_set) {
    std::puts("the effect's key is not the last one of the vehicle file");
    return 2;
  }
  if (model::Translation{}.with("side_force_per_s", kRate_per_s).side_force_per_s != kRate_per_s) {
    std::puts("the vehicle does not hold the effect's value");
    return 2;
  }
  sim::Plant plant = sim::measured_plant();
  plant.roll.trim_counts = plant.pitch.trim_counts = 0.0;
  plant.air = {};
  plant.air.linear_drag_per_s = 0.0;
  plant.air.attitude_disturbance_rad = 0.0;
  plant.air.side_force_per_s = kRate_per_s;
  plant.air.wind_m_s = {kWind_m_s, 0.0, 0.0};
  sim::Vehicle vehicle(plant, 1, {0.0, 0.0, 10.0});
  vehicle.advance(std::chrono::seconds(1));
  const double across_m_s = vehicle.state().velocity_w_m_s.y();
  // The wind blows from behind, so the force points to the right of the motion through the air.
  const double expected_m_s = -kWind_m_s * std::sin(kRate_per_s);
  if (std::abs(across_m_s - expected_m_s) > 0.02) {
    std::printf("after one second the speed across the wind is %g m/s, expected %g m/s\n", across_m_s, expected_m_s);
    return 2;
  }
  return 0;
}
