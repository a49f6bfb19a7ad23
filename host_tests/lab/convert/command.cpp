// SPDX-License-Identifier: BSD-3-Clause
// m100-lab convert: writes any readable log as CSV in canonical units on a uniform clock.
#include <algorithm>
#include <iostream>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/logs/write_csv.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/subcommands.h"

namespace m100::lab {
namespace {

struct ConvertOptions {
  std::string log, columns, out, map, json;
  double rate_hz = 100.0;
  bool list = false;
};

/// The reader's notes; one that concerns several columns is listed once.
std::vector<std::string> notes_of(const logs::FlightLog& log) {
  std::vector<std::string> all = log.notes;
  for (const std::string& note : log.gap_notes) {
    if (std::find(all.begin(), all.end(), note) == all.end()) {
      all.push_back(note);
    }
  }
  return all;
}

/// The samples of all stretches.
std::size_t rows_of(const logs::FlightLog& log) {
  std::size_t rows = 0;
  for (const logs::Flight& part : log.parts()) {
    rows += part.end - part.begin;
  }
  return rows;
}

/// The time of the last sample, as it stands in the log.
double end_of(const logs::FlightLog& log) {
  const logs::Flight last = log.parts().back();
  return last.start_s + static_cast<double>(last.end - 1 - last.begin) * log.period_s;
}

Json to_json(const ConvertOptions& options, const logs::FlightLog& log) {
  Json signals = Json::array();
  for (std::size_t i = 0; i < logs::kSignals; ++i) {
    if (log.has(static_cast<logs::Signal>(i))) {
      signals.push_back(logs::kSignalNames[i]);
    }
  }
  return {{"log", options.log},
          {"out", options.out},
          {"samples", rows_of(log)},
          {"from_s", log.start_s},
          {"to_s", end_of(log)},
          {"rate_hz", options.rate_hz},
          {"signals", std::move(signals)},
          {"alignment", {{"evidence", log.alignment.evidence}}},
          {"notes", notes_of(log)}};
}

/// The option --list: prints the names of the log's columns.
void list(const ConvertOptions& options) {
  const std::vector<std::string> names = logs::open_log(options.log)->names();
  for (const std::string& name : names) {
    std::cout << printable(name) << "\n";
  }
  write_json(options.json, Json{{"log", options.log}, {"columns", names}});
}

void run(const ConvertOptions& options) {
  companion::FileUse()
      .reads("--log", options.log)
      .reads("--columns", options.columns)
      .writes("--out", options.out)
      .writes("--map", options.map)
      .writes("--json", options.json)
      .check();
  if (options.list) {
    list(options);
    return;
  }
  if (options.columns.empty() || options.out.empty()) {
    throw InputError("convert", 0, options.columns.empty() ? "--columns" : "--out", "is required without --list");
  }
  const logs::FlightLog log = logs::load(options.log, options.columns, 1.0 / options.rate_hz);
  logs::write_csv(log, options.out);
  if (!options.map.empty()) {
    logs::write_column_map(log, options.map);
  }
  std::cout << printable(options.out) << ": " << rows_of(log) << " samples from " << log.start_s << " to "
            << end_of(log) << " s; streams aligned by " << log.alignment.evidence << "\n";
  for (const std::string& note : notes_of(log)) {
    std::cout << "  note: " << printable(note) << "\n";
  }
  write_json(options.json, to_json(options, log));
}

}  // namespace

void add_convert(companion::CommandLine& lab) {
  const auto [app, options] = lab.add_subcommand<ConvertOptions>(
      "convert", "convert any log (CSV, MAT, ULog, ArduPilot, ROS bags) to CSV in canonical units", run);
  app.add_option("--log,log", options->log, "log file").required();
  app.add_option("--columns", options->columns, "column map (TOML)");
  app.add_option("--out", options->out, "CSV to write");
  app.add_option("--map", options->map, "also write the column map that reads it back");
  app.add_option("--rate", options->rate_hz, "samples per second").from_to(1.0, 10000.0);
  app.add_option("--json", options->json, "summary of the written file, or with --list the columns, as JSON");
  app.add_flag("--list", options->list, "only list the columns that the log has");
}

}  // namespace m100::lab
