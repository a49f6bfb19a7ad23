// SPDX-License-Identifier: BSD-3-Clause
// m100-lab identify: a log, a declared model; what is missing, and how much better it is with it.
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>

#include "host_tests/tools/identify/json.h"
#include "host_tests/tools/identify/report.h"
#include "host_tests/tools/identify/request.h"
#include "host_tests/tools/identify/to_vehicle.h"
#include "host_tests/tools/input_error.h"
#include "host_tests/tools/logs/flight_log.h"
#include "host_tests/tools/option_words.h"
#include "host_tests/tools/subcommands.h"

namespace m100::tools {
namespace {

using identify::Range;

struct Options {
  std::string log, columns, axis, declare, train, validate, split, validation_log, validation_columns, vehicle, json,
      report;
  double noise_floor = 0.0;
  std::size_t draws = 200;
  std::uint64_t seed = 1;
};

std::vector<Range> ranges(const std::string& option, const std::string& text, const logs::FlightLog& log) {
  std::vector<Range> out;
  const double last_s = log.time_s(log.size - 1) + log.period_s;
  for (const std::string& part : parts(text, ',')) {
    const std::vector<std::string> ends = parts(part, ':');
    if (ends.size() != 2) {
      throw InputError(option, 0, part, "a range is FROM:TO in seconds");
    }
    const Range range{number(option, ends[0]), number(option, ends[1])};
    if (!(range.first < range.second)) {
      throw InputError(option, 0, part, "ends before it begins");
    }
    if (range.first < log.start_s - 1e-9 || range.second > last_s + 0.5) {
      std::ostringstream message;
      message << "outside of the log, which has " << log.start_s << " to " << last_s << " s";
      throw InputError(option + " " + part, 0, log.file, message.str());
    }
    out.push_back(range);
  }
  if (out.empty()) {
    throw InputError(option, 0, "", "is needed (or --split)");
  }
  return out;
}

/// "alternate:6": pieces of 6 s in turn for training and validation.
void split(const std::string& text, const logs::FlightLog& log, identify::Request& request) {
  const std::vector<std::string> halves = parts(text, ':');
  if (halves.size() != 2 || halves[0] != "alternate") {
    throw InputError("--split", 0, text, "the one split there is: alternate:SECONDS");
  }
  const double length_s = number("--split", halves[1]);
  if (!(length_s >= 2.5)) {
    throw InputError("--split", 0, text, "pieces must be at least 2.5 s long");
  }
  const double last_s = log.time_s(log.size - 1);
  for (int piece = 0; log.start_s + (piece + 1) * length_s <= last_s; ++piece) {
    const Range range{log.start_s + piece * length_s, log.start_s + (piece + 1) * length_s};
    (piece % 2 == 0 ? request.train : request.validate).push_back(range);
  }
}

void check_disjoint(const identify::Request& request) {
  if (request.log != request.validation_log) {
    return;
  }
  for (const Range& a : request.train) {
    for (const Range& b : request.validate) {
      if (a.first < b.second - 1e-9 && b.first < a.second - 1e-9) {
        throw InputError("--validate", 0, "", "overlaps --train: the error would be quoted on data the fit has seen");
      }
    }
  }
}

void run(const Options& options) {
  const logs::FlightLog log = logs::load(options.log, options.columns);
  std::optional<logs::FlightLog> other;
  if (!options.validation_log.empty()) {
    other = logs::load(options.validation_log,
                       options.validation_columns.empty() ? options.columns : options.validation_columns);
  }
  identify::Request request;
  request.axis = options.axis;
  request.declared = parts(options.declare, ',');
  request.log = &log;
  request.validation_log = other ? &*other : &log;
  request.noise_floor = options.noise_floor;
  request.bootstrap_draws = options.draws;
  request.seed = options.seed;
  if (!options.split.empty()) {
    if (!options.train.empty() || !options.validate.empty()) {
      throw InputError("--split", 0, options.split, "not together with --train or --validate");
    }
    split(options.split, log, request);
    if (other) {
      request.validate = {{other->start_s, other->time_s(other->size - 1)}};
    }
  } else {
    request.train = ranges("--train", options.train, log);
    request.validate = ranges("--validate", options.validate, *request.validation_log);
  }
  check_disjoint(request);
  const bool terminal = isatty(STDERR_FILENO) == 1;
  if (terminal) {
    request.progress = [](const std::string& line) { std::cerr << "\r\033[K  " << line << std::flush; };
  }
  identify::IdentifyResult result =
      request.axis == "translation" ? identify::identify_translation(request) : identify::identify_axis(request);
  if (terminal) {
    std::cerr << "\r\033[K";
  }
  if (!options.vehicle.empty()) {
    const std::string source = options.log.substr(options.log.find_last_of('/') + 1) + ", train " +
                               (options.split.empty() ? options.train : options.split) +
                               " s, m100-lab identify --axis " + options.axis;
    for (const std::string& homeless : identify::update_vehicle_file(options.vehicle, result, source)) {
      result.findings.push_back(homeless);
    }
  }
  std::cout << identify::to_text(result);
  if (!options.json.empty()) {
    std::ofstream file(options.json);
    file << identify::to_json(result).dump(1) << "\n";
    if (!file) {
      throw InputError(options.json, 0, "--json", "cannot be written");
    }
  }
  if (!options.report.empty()) {
    const identify::ReportOrigin origin{options.log.substr(options.log.find_last_of('/') + 1),
                                        options.split.empty() ? options.train + " s" : options.split,
                                        options.split.empty() ? options.validate + " s" : options.split, false};
    std::cout << "wrote " << identify::write_report(result, origin, options.report) << "\n";
  }
}

}  // namespace

void add_identify(CLI::App& lab) {
  CLI::App* app = lab.add_subcommand("identify", "find what the declared model lacks in a log, name it, add it");
  auto options = std::make_shared<Options>();
  app->add_option("--log", options->log, "flight log: CSV, MATLAB 5 MAT-file or ULog")->required();
  app->add_option("--columns", options->columns, "column map (TOML)")->required();
  app->add_option("--axis", options->axis, "roll, pitch, yaw_rate, climb or translation")
      ->required()
      ->check(CLI::IsMember({"roll", "pitch", "yaw_rate", "climb", "translation"}));
  app->add_option("--declare", options->declare,
                  "model believed before looking: first_order or second_order (translation: rigid_body), then effects "
                  "by name, with commas")
      ->required();
  app->add_option("--train", options->train, "FROM:TO[,FROM:TO...] in seconds of the log's clock");
  app->add_option("--validate", options->validate, "the same; must not overlap the training ranges");
  app->add_option("--split", options->split, "instead of ranges: alternate:SECONDS");
  app->add_option("--validate-log", options->validation_log, "another log, for the validation ranges");
  app->add_option("--validate-columns", options->validation_columns, "its column map, if not the same");
  app->add_option("--noise-floor", options->noise_floor, "root mean square that the air leaves, unit of the axis")
      ->check(CLI::NonNegativeNumber);
  app->add_option("--vehicle", options->vehicle, "vehicle file to write; an existing one keeps its other sections");
  app->add_option("--json", options->json, "result as JSON");
  app->add_option("--report", options->report, "folder for the HTML report");
  app->add_option("--draws", options->draws, "bootstrap draws")->check(CLI::Range(0, 10000));
  app->add_option("--seed", options->seed, "of the bootstrap");
  app->callback([options] { run(*options); });
}

}  // namespace m100::tools
