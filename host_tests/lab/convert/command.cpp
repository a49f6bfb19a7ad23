// SPDX-License-Identifier: BSD-3-Clause
// m100-lab convert: any log that can be read, as CSV in canonical units on a uniform clock.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/write_csv.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab {
namespace {

struct Options {
  std::string log, columns, out, map;
  double rate_hz = 100.0;
  bool list = false;
};

void run(const Options& options) {
  if (options.list) {
    for (const std::string& name : logs::open_log(options.log)->names()) {
      std::cout << printable(name) << "\n";
    }
    return;
  }
  if (options.columns.empty() || options.out.empty()) {
    throw InputError("convert", 0, options.columns.empty() ? "--columns" : "--out", "is needed (or --list)");
  }
  for (const std::string& input : {options.log, options.columns}) {
    refuse_overwriting(input, options.out, "--out");
    refuse_overwriting(input, options.map, "--map");
  }
  require_writable(options.out, "--out");
  require_writable(options.map, "--map");
  const logs::FlightLog log = logs::load(options.log, options.columns, 1.0 / options.rate_hz);
  logs::write_csv(log, options.out);
  if (!options.map.empty()) {
    logs::write_column_map(log, options.map);
  }
  std::cout << options.out << ": " << log.size << " samples from " << log.start_s << " to " << log.time_s(log.size - 1)
            << " s; streams aligned by " << log.alignment.evidence << "\n";
  for (const std::string& note : log.notes) {
    std::cout << "  " << printable(note) << "\n";
  }
}

}  // namespace

void add_convert(CLI::App& lab) {
  CLI::App* app =
      lab.add_subcommand("convert", "read any log (CSV, MAT, ULog, ArduPilot, ROS bags), write CSV in canonical units");
  auto options = std::make_shared<Options>();
  app->add_option("--log,log", options->log, "the log")->required();
  app->add_option("--columns", options->columns, "column map (TOML)");
  app->add_option("--out", options->out, "CSV to write");
  app->add_option("--map", options->map, "also write the column map that reads it back");
  app->add_option("--rate", options->rate_hz, "samples per second")->check(CLI::Range(1.0, 10000.0));
  app->add_flag("--list", options->list, "only list the columns that the log has");
  app->callback([options] { run(*options); });
}

}  // namespace m100::lab
