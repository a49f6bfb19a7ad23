// SPDX-License-Identifier: BSD-3-Clause
// Writes the files that a folder starts with, and applies the folder's numbers to a vehicle file.
#include "host_tests/lab/evening/initial_files.h"

#include <cmath>

#include "firmware/companion/files/vehicle_file.h"
#include "firmware/mpc/generated/gain_table.h"

namespace m100::lab::evening {
namespace {

/// The course that is flown before and after the correction: 1.5 m in x, then in y, half a metre up and to another
/// heading, back to the start, then two circles. It moves every channel, because a channel at rest shows no error.
constexpr std::string_view kCourse =
    R"(# The course that is flown before and after the correction. Change it before the step `course`, not after.
quintic 1.5 0 0 0 3
quintic 1.5 1.5 0.5 0.8 3
quintic 0 0 0 0 4
circle 1 0.8 2
)";
constexpr double kWeightFactor = 3.0;  ///< factor on the input weight for each of kWeightIncreases

void put(const Folder& folder, const std::string& name, std::string_view bytes) {
  if (!folder.has(name)) {
    write_file(folder.file(name), bytes);
  }
}

}  // namespace

void adjust(const Folder& folder, const std::string& vehicle) {
  companion::VehicleFile file = companion::load_vehicle(folder.file(vehicle));
  const std::map<std::string, double>& numbers = folder.numbers();
  if (numbers.contains(kWeightIncreases)) {
    model::flown_weights(file.vehicle).input *= std::pow(kWeightFactor, numbers.at(kWeightIncreases));
  }
  if (numbers.contains(kTrimmed)) {
    file.vehicle.roll.trim_counts = numbers.at(kTrimRoll);
    file.vehicle.pitch.trim_counts = numbers.at(kTrimPitch);
  }
  companion::save_vehicle(folder.file(vehicle), file.vehicle, file.sources);
}

void write_initial_files(const Folder& folder) {
  put(folder, "columns_hand.toml", kHandMap);  // the first: it marks the folder as an evening's
  put(folder, "flight.toml", kFlightFile);
  put(folder, "course.txt", kCourse);
  put(folder, "columns_flight.toml", kFlightMap);
  put(folder, "columns_climb.toml", kClimbMap);
  put(folder, "first_vehicle.toml", companion::to_text(mpc::generated::kVehicle, {}));
}

}  // namespace m100::lab::evening
