// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/sim/world/plant_file.h"

namespace m100::sim {

/// The plant that a vehicle file describes: all four axes with every key, mass, drag and thrust come from the file;
/// air, pose source, sensors and link are those of the measured plant.
Plant plant_of(const model::Vehicle& vehicle);
/// The base of plant files: the plant of the vehicle file at `vehicle_path` (option --plant-from), or the measured one
/// if the path is empty. Errors: companion::FileError.
Plant base_plant(const std::string& vehicle_path);
/// The plant of a command line: plant file and --plant-from, either or both of them empty.
Plant plant_of_options(const std::string& plant_path, const std::string& vehicle_path);

}  // namespace m100::sim
