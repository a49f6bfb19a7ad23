// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/corrected_vehicle.h"

#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/evening/flight_result.h"
#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/loop/vehicle_comparison.h"

namespace m100::lab::evening {

void write_corrected_vehicle(Folder& folder) {
  const model::Vehicle believed = companion::load_vehicle(folder.file("vehicle.toml")).vehicle;
  const companion::VehicleFile rates = companion::load_vehicle(folder.file("rates.toml"));
  companion::VehicleFile corrected = companion::load_vehicle(folder.file("tilts.toml"));
  const auto flown = [&](const char* name) {
    return std::pair{logs::load(folder.file(std::string(name) + ".ulg"), folder.file("columns_flight.toml")),
                     nominal(result_of(folder, std::string(name) + ".json"))};
  };
  const auto [excited, with_sticks] = flown("excite_rates");
  const loop::UnseenFlight moved{&excited, with_sticks.first + kSettled_s, with_sticks.second};
  for (const std::string channel : {"climb", "yaw_rate"}) {
    const bool better = loop::predicts_better(believed, rates.vehicle, moved, channel);
    folder.set_number("found." + channel, better ? 1.0 : 0.0);
    if (better) {
      corrected.vehicle = loop::with_channel(corrected.vehicle, rates.vehicle, channel);
      corrected.sources["axis." + channel] = rates.sources.at("axis." + channel);
    }
  }
  const auto [course, in_control] = flown("course");
  const loop::UnseenFlight flight{&course, in_control.first + kSettled_s, in_control.second};
  for (const VehicleAxis& axis : kVehicleAxes) {
    const std::string name = std::string("ahead.") + axis.name;
    folder.set_number(name + ".before", loop::error_at_1s(believed, flight, axis.name));
    folder.set_number(name + ".after", loop::error_at_1s(corrected.vehicle, flight, axis.name));
  }
  companion::save_vehicle(folder.file("corrected.toml"), corrected.vehicle, corrected.sources);
}

}  // namespace m100::lab::evening
