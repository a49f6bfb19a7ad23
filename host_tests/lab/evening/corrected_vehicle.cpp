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
  // The climb is judged on the measured height: the velocity in the log is the estimator's, which believes the old
  // model.
  const auto log_of = [&](const char* name, bool is_climb) {
    return logs::load(folder.file(std::string(name) + ".ulg"),
                      folder.file(is_climb ? "columns_climb.toml" : "columns_flight.toml"));
  };
  const auto with_sticks = nominal(result_of(folder, "excite_rates.json"));
  for (const std::string channel : {"climb", "yaw_rate"}) {
    const logs::FlightLog excited = log_of("excite_rates", channel == "climb");
    const loop::UnseenFlight moved{&excited, with_sticks.first + kSettled_s, with_sticks.second};
    const bool better = loop::predicts_better(believed, rates.vehicle, moved, channel);
    folder.set_number("found." + channel, better ? 1.0 : 0.0);
    if (better) {
      corrected.vehicle = loop::with_channel(corrected.vehicle, rates.vehicle, channel);
      corrected.sources["axis." + channel] = rates.sources.at("axis." + channel);
    }
  }
  const auto in_control = nominal(result_of(folder, "course.json"));
  for (const VehicleAxis& axis : kVehicleAxes) {
    const logs::FlightLog course = log_of("course", std::string_view(axis.name) == "climb");
    const loop::UnseenFlight flight{&course, in_control.first + kSettled_s, in_control.second};
    const std::string name = std::string("ahead.") + axis.name;
    folder.set_number(name + ".before", loop::error_at_1s(believed, flight, axis.name));
    folder.set_number(name + ".after", loop::error_at_1s(corrected.vehicle, flight, axis.name));
  }
  companion::save_vehicle(folder.file("corrected_model.toml"), corrected.vehicle, corrected.sources);
}

}  // namespace m100::lab::evening
