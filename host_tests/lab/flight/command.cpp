// SPDX-License-Identifier: BSD-3-Clause
// m100-lab flight: the page of a flight, or of two flights on the same axes.
#include <iostream>
#include <optional>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/key_file.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/companion/replay/replay.h"
#include "host_tests/lab/flight/page.h"
#include "host_tests/lab/flight/tracking.h"
#include "host_tests/lab/identify/prediction.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/logs/raw_log.h"
#include "host_tests/lab/loop/aligned_log.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/subcommands.h"
#include "protocol/aes256.h"

namespace m100::lab {
namespace {

struct FlightOptions {
  std::vector<std::string> logs;
  std::string out, json, key_file, title, note;
};

Json to_json(const Interval& one) { return {{"value", one.value}, {"low", one.low}, {"high", one.high}}; }

/// The page's numbers about tracking; null: the flight does not have the number.
Json flights_json(const std::vector<flight::FlightSeries>& flights) {
  Json out{{"flights", Json::array()}};
  std::vector<std::vector<flight::TrackingError>> errors;
  for (const flight::FlightSeries& one : flights) {
    errors.push_back(flight::tracking_errors(one));
    Json tracking;
    if (!errors.back().empty()) {
      const flight::Tracking found = flight::tracking_of(errors.back());
      tracking = {{"rms_m", found.rms_m.value},
                  {"rms_interval_m", to_json(found.rms_m)},
                  {"max_m", found.max_m},
                  {"horizontal_rms_m", found.horizontal_rms_m},
                  {"vertical_rms_m", found.vertical_rms_m},
                  {"poses", found.poses}};
    }
    out["flights"].push_back({{"name", one.name}, {"flew", one.flew()}, {"tracking", tracking}});
  }
  if (flights.size() > 1) {
    out["rms_difference_m"] = to_json(flight::compare_pair(errors.front(), errors.back()).difference_m);
  }
  return out;
}

/// Predicts the flight by the vehicle file that its log holds (identify::predict), and adds the errors. Nothing is
/// added to a flight without sticks of its own (a recording, or a flight by movement control) or of less than 6 s.
void add_predictions(const std::string& file, flight::FlightSeries& flight) {
  constexpr double kSettled_s = 1.0;
  constexpr double kShortest_s =
      5.0;  ///< fits two of the longest predictions after each other, and samples before them
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

void run(const FlightOptions& options) {
  companion::FileUse()
      .reads("log", options.logs)
      .reads("--key-file", options.key_file)
      .writes("--out", options.out)
      .writes("--json", options.json)
      .check();
  if (options.logs.size() > 2) {
    throw InputError(options.logs[2], 0, "", "a page shows one flight, or two: before and after");
  }
  std::optional<protocol::Aes256> cipher;
  if (!options.key_file.empty()) {
    cipher.emplace(companion::read_key(options.key_file));
  }
  std::vector<flight::FlightSeries> flights;
  for (const std::string& log : options.logs) {
    flights.push_back(flight::read_series(log, cipher ? &*cipher : nullptr));
    add_predictions(log, flights.back());
  }
  if (flights.size() > 1 && (!flights[0].flew() || !flights[1].flew())) {
    throw InputError(options.logs[flights[0].flew() ? 1 : 0], 0, "",
                     "in this log the law did not fly: it cannot be compared");
  }
  std::string title = options.title;
  if (title.empty()) {
    title = "Flight " + flights.front().name;
    title += flights.size() > 1 ? " (before) and " + flights.back().name + " (after)" : "";
  }
  flight::flight_page(flights, title, options.note).write(options.out);
  write_json(options.json, flights_json(flights).sorted());
  std::cout << flight::error_sentence(flights) << "\nwrote " << printable(options.out) << "\n";
}

}  // namespace

void add_flight(companion::CommandLine& lab) {
  const auto [command, options] = lab.add_subcommand<FlightOptions>(
      "flight", "the page of a flight: path, error, failsafe, pose, commands, battery; of two: before and after", run);
  command.add_option("log", options->logs, "log of 'm100 fly' or recording of 'm100 record'; two: before and after")
      .required();
  command.add_option("--out", options->out, "the page to write (HTML)").required();
  command.add_option("--json", options->json, "the errors as JSON");
  command.add_option("--key-file", options->key_file, "file with the app's key, for a flight with encrypted commands");
  command.add_option("--title", options->title, "title of the page; default: names of the logs");
  command.add_option("--note", options->note, "a sentence under the title");
}

}  // namespace m100::lab
