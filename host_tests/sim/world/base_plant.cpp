// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/base_plant.h"

#include "firmware/companion/files/vehicle_file.h"

// The base of a plant file: the measured plant, or that of a vehicle file.
namespace m100::sim {

Plant plant_of(const model::Vehicle& vehicle) {
  Plant plant = measured_plant();
  plant.roll = vehicle.roll;
  plant.pitch = vehicle.pitch;
  plant.yaw_rate = vehicle.yaw_rate;
  plant.climb = vehicle.climb;
  plant.mass_kg = vehicle.translation.mass_kg;
  static_cast<model::TranslationNumbers&>(plant.air) = vehicle.translation;
  return plant;
}

Plant base_plant(const std::string& vehicle_path) {
  return vehicle_path.empty() ? measured_plant() : plant_of(companion::load_vehicle(vehicle_path).vehicle);
}

Plant plant_of_options(const std::string& plant_path, const std::string& vehicle_path) {
  const Plant base = base_plant(vehicle_path);
  return plant_path.empty() ? base : load_plant(plant_path, base);
}

}  // namespace m100::sim
