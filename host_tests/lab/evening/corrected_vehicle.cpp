// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/evening/corrected_vehicle.h"

#include <string>

#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/evening/flight_result.h"
#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/loop/vehicle_comparison.h"

namespace m100::lab::evening {
namespace {

/// Takes the drag that was found in the excited flight, if no residual there is unexplained and it predicts the course
/// better. Records "found.translation", and "linear_drag_per_s" if the drag was taken.
void take_drag(Folder& folder, const identify::UnseenFlight& course, companion::VehicleFile& corrected) {
  folder.set_number("found.translation", 0.0);
  if (!folder.has("drag.toml") || !folder.has("flown_translation.json")) {
    return;
  }
  const Json answer = result_of(folder, "flown_translation.json");
  const companion::VehicleFile found = companion::load_vehicle(folder.file("drag.toml"));
  const model::Vehicle with_drag = loop::with_channel(corrected.vehicle, found.vehicle, "translation");
  if (answer.at("verdict") == "unexplained" ||
      !loop::predicts_better(corrected.vehicle, with_drag, course, "translation")) {
    return;
  }
  corrected.vehicle = with_drag;
  corrected.sources["translation"] = found.sources.at("translation");
  folder.set_number("found.translation", 1.0);
  folder.set_number("linear_drag_per_s", with_drag.translation.linear_drag_per_s);
}

}  // namespace

void write_corrected_vehicle(Folder& folder) {
  const model::Vehicle believed = companion::load_vehicle(folder.file("vehicle.toml")).vehicle;
  const companion::VehicleFile rates = companion::load_vehicle(folder.file("rates.toml"));
  companion::VehicleFile corrected = companion::load_vehicle(folder.file("tilts.toml"));
  // The climb is judged by the measured height, because the velocity in the log is an estimate by the old model.
  const auto log_of = [&](const char* name, bool is_climb) {
    return logs::load(folder.file(std::string(name) + ".ulg"),
                      folder.file(is_climb ? "columns_climb.toml" : "columns_flight.toml"));
  };
  const auto in_control = nominal(result_of(folder, "course.json"));
  const logs::FlightLog from_height = log_of("course", true), flown = log_of("course", false);
  const auto course = [&](std::string_view channel) {
    return identify::UnseenFlight{channel == "climb" ? &from_height : &flown,
                                  {{in_control.first + kSettled_s, in_control.second}}};
  };
  const auto with_sticks = nominal(result_of(folder, "excite_rates.json"));
  for (const std::string channel : {"climb", "yaw_rate"}) {
    const logs::FlightLog excited = log_of("excite_rates", channel == "climb");
    const identify::UnseenFlight moved{&excited, {{with_sticks.first + kSettled_s, with_sticks.second}}};
    // The course, which no fit has used, has small stick movements: the new model must not predict it worse.
    const bool better = loop::predicts_better(believed, rates.vehicle, moved, channel) &&
                        identify::error_at_1s(rates.vehicle, course(channel), channel) <=
                            identify::error_at_1s(believed, course(channel), channel);
    folder.set_number("found." + channel, better ? 1.0 : 0.0);
    if (better) {
      corrected.vehicle = loop::with_channel(corrected.vehicle, rates.vehicle, channel);
      corrected.sources["axis." + channel] = rates.sources.at("axis." + channel);
    }
  }
  take_drag(folder, course("translation"), corrected);
  for (const VehicleAxis& axis : kVehicleAxes) {
    const identify::UnseenFlight flight = course(axis.name);
    const std::string name = std::string("ahead.") + axis.name;
    folder.set_number(name + ".before", identify::error_at_1s(believed, flight, axis.name));
    folder.set_number(name + ".after", identify::error_at_1s(corrected.vehicle, flight, axis.name));
  }
  companion::save_vehicle(folder.file("corrected_model.toml"), corrected.vehicle, corrected.sources);
}

}  // namespace m100::lab::evening
