// SPDX-License-Identifier: BSD-3-Clause
// m100-lab identify: a log, a declared model; what is missing, and how much better it is with it.
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/identify/answer/forecast.h"
#include "host_tests/lab/identify/answer/json.h"
#include "host_tests/lab/identify/answer/report.h"
#include "host_tests/lab/identify/answer/to_vehicle.h"
#include "host_tests/lab/identify/log_ranges.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/option_checks.h"
#include "host_tests/lab/option_words.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/read_json.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab {
namespace {

using identify::Range;

struct IdentifyOptions {
  std::vector<std::string> logs, columns;
  std::string axis, declare, train, validate, split, within, validation_log, validation_columns, believed, vehicle,
      json, report, forecast;
  double noise_floor = 0.0;
  double wind_from_first_s = 0.0;
  std::size_t refits = 40;
};

logs::FlightLog load_all(const IdentifyOptions& options) {
  if (options.columns.size() != 1 && options.columns.size() != options.logs.size()) {
    throw InputError("--columns", 0, "", "give one map for all logs, or one for each --log in the same order");
  }
  std::vector<logs::FlightLog> all;
  for (std::size_t i = 0; i < options.logs.size(); ++i) {
    all.push_back(logs::load(options.logs[i], options.columns[options.columns.size() == 1 ? 0 : i]));
  }
  return logs::joined(std::move(all));
}

/// The log of --validate-log, where there is one.
std::optional<logs::FlightLog> load_other(const IdentifyOptions& options) {
  if (options.validation_log.empty()) {
    if (!options.validation_columns.empty()) {
      throw InputError("--validate-columns", 0, "", "is of --validate-log, which is not given");
    }
    return std::nullopt;
  }
  return logs::load(options.validation_log,
                    options.validation_columns.empty() ? options.columns.front() : options.validation_columns);
}

/// Files are looked at before the work: what cannot be read or written, or would overwrite what is read.
void check_files(const IdentifyOptions& options) {
  companion::FileUse()
      .reads("--log", options.logs)
      .reads("--columns", options.columns)
      .reads("--validate-log", options.validation_log)
      .reads("--validate-columns", options.validation_columns)
      .reads("--vehicle-believed", options.believed == options.vehicle ? "" : options.believed)  // brought up to date
      .reads("--forecast", options.forecast)
      .writes("--json", options.json)
      .writes("--vehicle", options.vehicle)
      .fills("--report", options.report, options.axis + ".html")
      .check();
  for (const std::string& vehicle : {options.believed, options.vehicle}) {
    if (!vehicle.empty() && std::filesystem::exists(vehicle)) {
      (void)companion::load_vehicle(vehicle);  // what it says is wanted after the work; that it can be read, before
    }
  }
}

/// @throws InputError where the log cannot tell the gain of a stick: a vehicle file holds it per count.
void check_gain_of_sticks(const IdentifyOptions& options, const logs::FlightLog& log) {
  using logs::Signal;
  const Signal stick = options.axis == "roll"       ? Signal::kStickRoll
                       : options.axis == "pitch"    ? Signal::kStickPitch
                       : options.axis == "yaw_rate" ? Signal::kStickYaw
                       : options.axis == "climb"    ? Signal::kStickThrottle
                                                    : Signal::kCount;
  if (!options.vehicle.empty() && stick != Signal::kCount && !log.has(stick)) {
    throw InputError(options.vehicle, 0, "--vehicle",
                     "needs " + std::string(logs::name_of(stick)) + " in the log: a command does not tell its gain");
  }
}

/// What shows that the column map or the clock is wrong: such numbers must not fly. Empty: nothing.
std::string misread(const identify::IdentifyResult& result) {
  for (const identify::Finding& finding : result.findings) {
    const bool wrong = finding.what == "sign_reversed" || finding.what == "swapped_axes" ||
                       finding.what == "wrong_unit" || finding.what == "clock_shift";
    if (wrong && finding.certain) {
      return finding.text;
    }
  }
  return "";
}

std::string base_names(const std::vector<std::string>& files) {
  std::string out;
  for (const std::string& file : files) {
    out += (out.empty() ? "" : " + ") + file.substr(file.find_last_of('/') + 1);
  }
  return out;
}

/// Null: there is none. @throws InputError
nlohmann::json read_forecast(const IdentifyOptions& options) {
  if (options.forecast.empty()) {
    return nullptr;
  }
  nlohmann::json forecast = parse_json(whole_file(options.forecast));
  if (!forecast.is_object() || !forecast.contains("forecast")) {
    throw InputError(options.forecast, 0, "", "is no forecast of m100-lab excite --json");
  }
  identify::IdentifyResult nothing;  // every value is asked for once before the work
  nothing.axis = options.axis;
  of_json(options.forecast, "is no forecast of m100-lab excite --json", [&] {
    if (const nlohmann::ordered_json one = identify::compare_with_forecast(forecast, nothing); !one.empty()) {
      static_cast<void>(identify::forecast_sentence(one));
    }
  });
  return forecast;
}

/// What the flight was made for, beside what it showed; a sentence on stdout. Empty: no forecast, or of another axis.
nlohmann::ordered_json compared(const nlohmann::json& forecast, const identify::IdentifyResult& result) {
  if (forecast.is_null()) {
    return {};
  }
  nlohmann::ordered_json comparison = identify::compare_with_forecast(forecast, result);
  if (!comparison.empty()) {
    comparison["text"] = identify::forecast_sentence(comparison);
    std::cout << "  forecast: " << printable(comparison["text"].get<std::string>()) << "\n";
  }
  return comparison;
}

/// Training and validation ranges, from --split or from --train and --validate.
void ask_for_ranges(const IdentifyOptions& options, const logs::FlightLog& log, const logs::FlightLog* other,
                    identify::Request& request) {
  if (!options.split.empty()) {
    if (!options.train.empty() || !options.validate.empty()) {
      throw InputError("--split", 0, options.split, "not together with --train or --validate");
    }
    identify::split(options.split, options.within, log, request);
    if (other != nullptr) {
      request.validate = {{other->start_s, other->time_s(other->size - 1)}};
    }
  } else {
    if (!options.within.empty()) {
      throw InputError("--within", 0, options.within,
                       "belongs to --split; with --train and --validate there is no need");
    }
    request.train = identify::ranges("--train", options.train, log);
    request.validate = identify::ranges("--validate", options.validate, *request.validation_log);
  }
}

/// @throws InputError
double wind_from_first(const IdentifyOptions& options) {
  constexpr double kBlock_s = 2.5;
  if (options.wind_from_first_s == 0.0) {
    return 0.0;
  }
  if (options.axis != "translation") {
    throw InputError("--wind-from-first", 0, options.axis, "is a question of --axis translation");
  }
  if (!(options.wind_from_first_s >= kBlock_s && options.wind_from_first_s < 1e6)) {
    throw InputError("--wind-from-first", 0, std::to_string(options.wind_from_first_s),
                     "must be at least 2.5 s: a wind is estimated from whole blocks");
  }
  return options.wind_from_first_s;
}

void find_gaps(const identify::Request& request, identify::IdentifyResult& result) {
  std::vector<Range> used = request.train;
  const bool one_log = request.log == request.validation_log;
  if (one_log) {
    used.insert(used.end(), request.validate.begin(), request.validate.end());
  }
  identify::find_gaps(*request.log, used, result.findings);
  if (!one_log) {
    identify::find_gaps(*request.validation_log, request.validate, result.findings);
  }
}

void write_answer(const IdentifyOptions& options, const identify::IdentifyResult& result,
                  const nlohmann::ordered_json& comparison) {
  if (options.json.empty()) {
    return;
  }
  nlohmann::ordered_json answer = identify::to_json(result);
  if (!comparison.empty()) {
    answer["forecast"] = comparison;
  }
  write_json(options.json, answer);
}

/// What shall be asked of the logs, which must outlive the request.
identify::Request request_of(const IdentifyOptions& options, const logs::FlightLog& log, const logs::FlightLog* other) {
  identify::Request request;
  request.axis = options.axis;
  request.declared = list_of("--declare", options.declare);
  request.log = &log;
  request.validation_log = other != nullptr ? other : &log;
  request.noise_floor = options.noise_floor;
  request.wind_from_first_s = wind_from_first(options);
  request.refits = options.refits;
  ask_for_ranges(options, log, other, request);
  identify::refuse_data_used_twice(request);
  return request;
}

/// The answer; on a terminal its progress is shown meanwhile.
identify::IdentifyResult answer_to(identify::Request& request) {
  const bool terminal = isatty(STDERR_FILENO) == 1;
  if (terminal) {
    request.progress = [](const std::string& line) { std::cerr << "\r\033[K  " << line << std::flush; };
  }
  identify::IdentifyResult result =
      request.axis == "translation" ? identify::identify_translation(request) : identify::identify_axis(request);
  if (terminal) {
    std::cerr << "\r\033[K";
  }
  return result;
}

/// What has no place in the vehicle file is said among the findings.
void update_vehicle(const IdentifyOptions& options, identify::IdentifyResult& result) {
  const std::string source = base_names(options.logs) + ", train " +
                             (options.split.empty() ? options.train : options.split) + " s, m100-lab identify --axis " +
                             options.axis;
  for (const std::string& homeless : identify::update_vehicle_file(options.vehicle, result, source)) {
    result.findings.push_back(identify::note(homeless));
  }
}

void write_page(const IdentifyOptions& options, const identify::IdentifyResult& result) {
  if (options.report.empty()) {
    return;
  }
  const bool split = !options.split.empty();
  const identify::ReportOrigin origin{base_names(options.logs), split ? options.split : options.train + " s",
                                      split ? options.split : options.validate + " s", false};
  std::cout << "wrote " << printable(identify::write_report(result, origin, options.report)) << "\n";
}

void run(const IdentifyOptions& options) {
  check_files(options);
  const nlohmann::json forecast = read_forecast(options);
  const logs::FlightLog log = load_all(options);
  check_gain_of_sticks(options, log);
  const std::optional<logs::FlightLog> other = load_other(options);
  identify::Request request = request_of(options, log, other ? &*other : nullptr);
  identify::IdentifyResult result = answer_to(request);
  find_gaps(request, result);
  if (!options.believed.empty()) {
    result.refitted = identify::refitted(options.believed, result);
  }
  const std::string wrong = misread(result);
  if (!options.vehicle.empty() && wrong.empty()) {
    update_vehicle(options, result);
  }
  identify::date_findings(request, result.findings);
  std::cout << identify::to_text(result);
  const nlohmann::ordered_json comparison = compared(forecast, result);
  write_answer(options, result, comparison);
  write_page(options, result);
  if (!options.vehicle.empty() && !wrong.empty()) {
    std::cerr << printable(options.vehicle + ": '--vehicle': is not written: " + wrong) << "\n";
    throw CLI::RuntimeError(kAnswerIsNo);
  }
}

}  // namespace

void add_identify(CLI::App& lab) {
  CLI::App* app = lab.add_subcommand("identify", "find what the declared model lacks in a log, name it, add it");
  auto options = std::make_shared<IdentifyOptions>();
  app->add_option("--log", options->logs,
                  "flight log: CSV, MATLAB 5 MAT-file, ULog, ArduPilot .bin, ROS bag; may stand more than once")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app->add_option("--columns", options->columns, "column map (TOML): one for all logs, or one for each")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app->add_option("--axis", options->axis, "roll, pitch, yaw_rate, climb or translation")
      ->required()
      ->check(CLI::IsMember({"roll", "pitch", "yaw_rate", "climb", "translation"}));
  app->add_option("--declare", options->declare,
                  "model believed before looking: first_order or second_order (translation: rigid_body), then effects "
                  "by name, with commas")
      ->required();
  app->add_option("--train", options->train,
                  "FROM:TO[,FROM:TO...] in seconds of the log's clock; with several logs 1@FROM:TO,2@FROM:TO");
  app->add_option("--validate", options->validate, "the same; must not overlap the training ranges");
  app->add_option("--split", options->split, "instead of ranges: alternate:SECONDS");
  app->add_option("--within", options->within, "ranges that --split cuts; without it the whole log");
  app->add_option("--validate-log", options->validation_log, "another log, for the validation ranges");
  app->add_option("--validate-columns", options->validation_columns, "its column map, if not the same");
  app->add_option("--noise-floor", options->noise_floor, "root mean square that the air leaves, unit of the axis")
      ->check(from_to(0.0, 1e6));
  app->add_option("--wind-from-first", options->wind_from_first_s,
                  "translation: one model, and each flight's wind estimated from its first so many seconds (10 in a "
                  "wind tunnel), in which no error is counted");
  app->add_option("--vehicle", options->vehicle, "vehicle file to write; an existing one keeps its other sections");
  app->add_option("--vehicle-believed", options->believed,
                  "vehicle file that was believed: its numbers are set against those found");
  app->add_option("--forecast", options->forecast,
                  "JSON of m100-lab excite: what the flight was to tell apart, compared with what was found");
  app->add_option("--json", options->json, "result as JSON");
  app->add_option("--report", options->report, "folder for the HTML report");
  app->add_option("--refits,--draws", options->refits,
                  "fits with a part of the blocks left out, for the intervals: at most 40; 0: no intervals")
      ->check(CLI::Range(0, 10000));
  app->callback([options] { run(*options); });
}

}  // namespace m100::lab
