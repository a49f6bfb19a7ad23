// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/flight/predictions.h"

#include "firmware/companion/files/vehicle_file.h"
#include "firmware/companion/replay/replay.h"
#include "host_tests/lab/identify/prediction.h"
#include "host_tests/lab/logs/raw_log.h"
#include "host_tests/lab/loop/aligned_log.h"

namespace m100::lab::flight {
namespace {

constexpr double kSettled_s = 1.0;
constexpr double kShortest_s = 5.0;  ///< fits two of the longest predictions after each other, and samples before them

}  // namespace

void add_predictions(const std::string& file, FlightSeries& flight) {
  if (!flight.flew() || flight.end_s - flight.control_s < kSettled_s + kShortest_s) {
    return;
  }
  try {
    const companion::RecordedFlight log = companion::read_flight(file);
    if (log.notes.at(companion::kChannelNote).starts_with("movement")) {
      return;
    }
    const model::Vehicle vehicle =
        companion::parse_vehicle(log.notes.at(companion::kVehicleNote), companion::kVehicleNote).vehicle;
    logs::FlightLog signals =
        logs::load(*logs::open_log(file), logs::parse_column_map(loop::own_columns(), "(our own flight log)"));
    const double start_s = 1e-6 * static_cast<double>(log.ticks.front().record.timestamp);
    const identify::UnseenFlight flown{&signals, {{start_s + flight.control_s + kSettled_s, start_s + flight.end_s}}};
    identify::Prediction found = identify::predict(vehicle, flown);
    // The climb speed in the log is an estimate by the vehicle file, so the measured height is used instead.
    signals.of(logs::Signal::kVelocityZ).clear();
    found.climb_m_s = identify::predict(vehicle, flown).climb_m_s;
    for (const identify::Quantity& quantity : identify::kQuantities) {
      const auto& errors = found.*quantity.member;
      flight.predictions.push_back(
          {quantity.member == &identify::Prediction::climb_m_s ? identify::kClimbByHeight : quantity.name,
           {errors.begin(), errors.end()}});
    }
  } catch (const std::exception& wrong) {
    flight.notes.push_back(std::string("The vehicle file's prediction is missing: ") + wrong.what());
  }
}

}  // namespace m100::lab::flight
