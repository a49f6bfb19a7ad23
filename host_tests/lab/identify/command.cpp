// SPDX-License-Identifier: BSD-3-Clause
// m100-lab identify: finds the effects that a declared model lacks in a log, and how much they improve it.
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/data/log_ranges.h"
#include "host_tests/lab/identify/output/forecast_comparison.h"
#include "host_tests/lab/identify/output/report.h"
#include "host_tests/lab/identify/output/result_text.h"
#include "host_tests/lab/identify/output/vehicle_update.h"
#include "host_tests/lab/identify/prediction.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/translation_pipeline.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/logs/alignment/capture_alignment.h"
#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/logs/join.h"
#include "host_tests/lab/option_words.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab {
namespace {

using identify::Range;

struct IdentifyOptions {
  std::vector<std::string> logs, columns;
  std::string axis, declare, train, validate, split, within, validation_log, validation_columns, believed, vehicle,
      vehicle_declared, json, report, forecast;
  double noise_floor = 0.0;
  double wind_from_first_s = 0.0;
  std::size_t refits = 40;
};

logs::FlightLog load_one(const IdentifyOptions& options, const std::string& file, const std::string& columns) {
  logs::FlightLog log = logs::load(file, columns);
  if (options.axis == "translation") {
    log = logs::with_aligned_position(std::move(log));
  }
  logs::count_from_begin(log);
  return log;
}

logs::FlightLog load_all(const IdentifyOptions& options) {
  if (options.columns.size() != 1 && options.columns.size() != options.logs.size()) {
    throw InputError("--columns", 0, "", "give one map for all logs, or one per --log in the same order");
  }
  std::vector<logs::FlightLog> all;
  for (std::size_t i = 0; i < options.logs.size(); ++i) {
    all.push_back(load_one(options, options.logs[i], options.columns[options.columns.size() == 1 ? 0 : i]));
  }
  return logs::joined(std::move(all));
}

/// The log of --validate-log, where there is one.
std::optional<logs::FlightLog> load_other(const IdentifyOptions& options) {
  if (options.validation_log.empty()) {
    if (!options.validation_columns.empty()) {
      throw InputError("--validate-columns", 0, "", "needs --validate-log");
    }
    return std::nullopt;
  }
  return load_one(options, options.validation_log,
                  options.validation_columns.empty() ? options.columns.front() : options.validation_columns);
}

/// Checks before the work that all files can be read or written, and that no output overwrites an input.
void check_files(const IdentifyOptions& options) {
  companion::FileUse()
      .reads("--log", options.logs)
      .reads("--columns", options.columns)
      .reads("--validate-log", options.validation_log)
      .reads("--validate-columns", options.validation_columns)
      .reads("--vehicle-believed", options.believed == options.vehicle ? "" : options.believed)  // same file: updated
      .reads("--forecast", options.forecast)
      .writes("--json", options.json)
      .writes("--vehicle", options.vehicle)
      .writes("--vehicle-declared", options.vehicle_declared)
      .fills("--report", options.report, options.axis + ".html")
      .fills("--report", options.report, options.axis + ".csv")
      .check();
  if (!options.vehicle_declared.empty() && options.vehicle.empty()) {
    throw InputError("--vehicle-declared", 0, "", "needs --vehicle");
  }
  for (const std::string& vehicle : {options.believed, options.vehicle, options.vehicle_declared}) {
    if (!vehicle.empty() && std::filesystem::exists(vehicle)) {
      (void)companion::load_vehicle(vehicle);  // an invalid file is refused here; it is read again after the work
    }
  }
}

/// Checks, if --vehicle is given for a stick axis, that the log shows the gain per count. @throws InputError: the stick
/// is not in the log, or is never moved beyond 5 counts.
void check_gain_of_sticks(const IdentifyOptions& options, const logs::FlightLog& log) {
  using logs::Signal;
  const Signal stick = options.axis == "roll"       ? Signal::kStickRoll
                       : options.axis == "pitch"    ? Signal::kStickPitch
                       : options.axis == "yaw_rate" ? Signal::kStickYaw
                       : options.axis == "climb"    ? Signal::kStickThrottle
                                                    : Signal::kCount;
  if (!options.vehicle.empty() && stick != Signal::kCount && !log.has(stick)) {
    throw InputError(
        options.vehicle, 0, "--vehicle",
        "needs " + std::string(logs::name_of(stick)) + " in the log: the gain per count cannot be found from commands");
  }
  const auto is_large = [](double counts) { return std::abs(counts) > 5.0; };  // below: a fraction of the travel
  if (!options.vehicle.empty() && stick != Signal::kCount && std::ranges::none_of(log.of(stick), is_large)) {
    throw InputError(log.columns, 0, std::string(logs::name_of(stick)),
                     "stays within 5 counts of 660: it was not moved, or its scale is wrong");
  }
}

std::string base_names(const std::vector<std::string>& files) {
  std::string out;
  for (const std::string& file : files) {
    out += (out.empty() ? "" : " + ") + file.substr(file.find_last_of('/') + 1);
  }
  return out;
}

/// The file of --forecast; null: none was given. @throws InputError: it is not a forecast.
Json read_forecast(const IdentifyOptions& options) {
  if (options.forecast.empty()) {
    return nullptr;
  }
  Json forecast = Json::parse(whole_file(options.forecast));
  if (!forecast.is_object() || !forecast.contains("forecast")) {
    throw InputError(options.forecast, 0, "", "is not a forecast of m100-lab excite --json");
  }
  identify::IdentifyResult nothing;  // reads every value once before the work
  nothing.axis = options.axis;
  of_json(options.forecast, "is not a forecast of m100-lab excite --json", [&] {
    if (const Json one = identify::compare_with_forecast(forecast, nothing); !one.empty()) {
      static_cast<void>(identify::forecast_sentence(one));
    }
  });
  return forecast;
}

/// Compares the forecast of the flight with its result; prints a sentence on stdout. Empty: there is no forecast, or
/// it is for another axis.
Json compared(const Json& forecast, const identify::IdentifyResult& result) {
  if (forecast.is_null()) {
    return {};
  }
  Json comparison = identify::compare_with_forecast(forecast, result);
  if (!comparison.empty()) {
    comparison["text"] = identify::forecast_sentence(comparison);
    std::cout << "  forecast: " << printable(comparison["text"].get<std::string>()) << "\n";
  }
  return comparison;
}

/// Sets the training and validation ranges, from --split or from --train and --validate. With --split, a log of
/// --validate-log is for validation as a whole, and all pieces of the --log files are for training.
void require_ranges(const IdentifyOptions& options, const logs::FlightLog& log, const logs::FlightLog* other,
                    identify::Request& request) {
  if (!options.split.empty()) {
    if (!options.train.empty() || !options.validate.empty()) {
      throw InputError("--split", 0, options.split, "cannot be combined with --train or --validate");
    }
    identify::split(options.split, options.within, log, request);
    if (other != nullptr) {
      request.validate = {{other->start_s, other->time_s(other->size - 1)}};
    }
  } else {
    if (!options.within.empty()) {
      throw InputError("--within", 0, options.within,
                       "needs --split; --train and --validate name their ranges themselves");
    }
    request.train = identify::ranges("--train", options.train, log);
    request.validate = identify::ranges("--validate", options.validate, *request.validation_log);
  }
}

/// The seconds of --wind-from-first; 0: not given. @throws InputError: another axis than translation, or below 2.5 s.
double wind_from_first(const IdentifyOptions& options) {
  constexpr double kBlock_s = 2.5;
  if (options.wind_from_first_s == 0.0) {
    return 0.0;
  }
  if (options.axis != "translation") {
    throw InputError("--wind-from-first", 0, options.axis, "needs --axis translation");
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

void write_result(const IdentifyOptions& options, const identify::IdentifyResult& result, const Json& comparison) {
  if (options.json.empty()) {
    return;
  }
  Json answer = identify::to_json(result);
  if (!comparison.empty()) {
    answer["forecast"] = comparison;
  }
  write_json(options.json, answer);
}

/// The request of the options. The logs must outlive it.
identify::Request request_of(const IdentifyOptions& options, const logs::FlightLog& log, const logs::FlightLog* other) {
  identify::Request request;
  request.axis = options.axis;
  request.declared = list_of("--declare", options.declare);
  request.log = &log;
  request.validation_log = other != nullptr ? other : &log;
  request.noise_floor = options.noise_floor;
  request.wind_from_first_s = wind_from_first(options);
  request.refits = options.refits;
  require_ranges(options, log, other, request);
  identify::reject_reused_data(request);
  return request;
}

/// The result of the request. Shows the progress on standard error if that is a terminal.
identify::IdentifyResult result_of(identify::Request& request) {
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

/// Updates the vehicle files; adds a finding for each parameter that the identified one cannot hold.
void update_vehicles(const IdentifyOptions& options, identify::IdentifyResult& result) {
  const std::string source = base_names(options.logs) + ", train " +
                             (options.split.empty() ? options.train : options.split) + " s, m100-lab identify --axis " +
                             options.axis;
  if (!options.vehicle_declared.empty()) {
    identify::IdentifyResult declared = result;
    declared.final_model = result.declared;
    identify::update_vehicle_file(options.vehicle_declared, declared, source + ", as declared");
  }
  for (const std::string& not_in_file : identify::update_vehicle_file(options.vehicle, result, source)) {
    result.findings.push_back(identify::note(not_in_file));
  }
}

/// Predicts the motion of the validation part from its sticks by both vehicle files, where these have the axes.
void predict_motion(const IdentifyOptions& options, const identify::Request& request,
                    identify::IdentifyResult& result) {
  using logs::Signal;
  const logs::FlightLog& log = *request.validation_log;
  constexpr std::array kNeeded{Signal::kStickRoll,    Signal::kStickPitch,    Signal::kStickThrottle,
                               Signal::kAttitudeRoll, Signal::kAttitudePitch, Signal::kAttitudeYaw};
  if (options.axis != "translation" || options.vehicle_declared.empty() || !log.has3(Signal::kPositionX) ||
      !std::ranges::all_of(kNeeded, [&](Signal one) { return log.has(one); })) {
    return;
  }
  for (const auto& [file, model] :
       {std::pair{options.vehicle_declared, &result.declared}, std::pair{options.vehicle, &result.final_model}}) {
    const model::Vehicle vehicle = companion::load_vehicle(file).vehicle;
    if (vehicle.roll.is_identified() && vehicle.pitch.is_identified() && vehicle.climb.is_identified()) {
      const identify::Prediction found = identify::predict_motion(vehicle, {&log, request.validate});
      model->position_rmse = found.position_m;
      model->velocity_rmse = found.velocity_m_s;
    }
  }
}

void write_page(const IdentifyOptions& options, const identify::IdentifyResult& result) {
  if (options.report.empty()) {
    return;
  }
  const bool split = !options.split.empty();
  const std::string other = options.validation_log.empty() ? "" : " of " + base_names({options.validation_log});
  const std::string validation = !split ? options.validate + " s" : other.empty() ? options.split : "all";
  const identify::ReportOrigin origin{base_names(options.logs), split ? options.split : options.train + " s",
                                      validation + other};
  std::cout << "wrote " << printable(identify::write_report(result, origin, options.report)) << "\n";
}

void run(const IdentifyOptions& options) {
  check_files(options);
  const Json forecast = read_forecast(options);
  const logs::FlightLog log = load_all(options);
  check_gain_of_sticks(options, log);
  const std::optional<logs::FlightLog> other = load_other(options);
  identify::Request request = request_of(options, log, other ? &*other : nullptr);
  identify::IdentifyResult result = result_of(request);
  find_gaps(request, result);
  if (!options.believed.empty()) {
    result.refitted = identify::refitted(companion::load_vehicle(options.believed).vehicle, result);
  }
  const std::string wrong = identify::misreading(result);
  if (!options.vehicle.empty() && wrong.empty()) {
    update_vehicles(options, result);
    predict_motion(options, request, result);
  }
  identify::date_findings(request, result.findings);
  std::cout << identify::to_text(result);
  const Json comparison = compared(forecast, result);
  write_result(options, result, comparison);
  write_page(options, result);
  if (!options.vehicle.empty() && !wrong.empty()) {
    std::cerr << printable(options.vehicle + ": '--vehicle': not written: " + wrong) << "\n";
    throw companion::AnswerIsNo();
  }
}

}  // namespace

void add_identify(companion::CommandLine& lab) {
  const auto [app, options] = lab.add_subcommand<IdentifyOptions>(
      "identify", "find, name and add the effects of a flight log that the declared model lacks", run);
  app.add_option("--log", options->logs,
                 "flight log: CSV, MATLAB 5 MAT-file, ULog, ArduPilot .bin, ROS bag; may be repeated")
      .required()
      .takes_one_each();
  app.add_option("--columns", options->columns, "column map (TOML): one for all logs, or one for each")
      .required()
      .takes_one_each();
  app.add_option("--axis", options->axis, "roll, pitch, yaw_rate, climb or translation")
      .required()
      .one_of({"roll", "pitch", "yaw_rate", "climb", "translation"});
  app.add_option("--declare", options->declare,
                 "model to start from: first_order or second_order (translation: rigid_body), then names of effects, "
                 "separated by commas")
      .required();
  app.add_option("--train", options->train,
                 "FROM:TO[,FROM:TO...] in seconds of the log's clock; with several logs 1@FROM:TO,2@FROM:TO");
  app.add_option("--validate", options->validate,
                 "validation ranges, in the same form; they must not overlap the training ranges");
  app.add_option(
      "--split", options->split,
      "instead of --train and --validate: alternate:SECONDS, pieces used for training and validation in turn");
  app.add_option("--within", options->within, "ranges that --split divides; default: the whole log");
  app.add_option("--validate-log", options->validation_log, "another log, for the validation ranges");
  app.add_option("--validate-columns", options->validation_columns,
                 "column map of --validate-log; default: the first --columns");
  app.add_option("--noise-floor", options->noise_floor,
                 "root mean square error that air and noise alone cause, in the unit of the axis")
      .from_to(0.0, 1e6);
  app.add_option("--wind-from-first", options->wind_from_first_s,
                 "translation: estimate the wind of each flight from its first SECONDS (10 in a wind tunnel); no error "
                 "is counted in them");
  app.add_option("--vehicle", options->vehicle, "vehicle file to write; an existing one keeps its other sections");
  app.add_option(
      "--vehicle-declared", options->vehicle_declared,
      "vehicle file to write with the declared model, beside --vehicle with the identified one; for translation, "
      "both then predict the position from the sticks");
  app.add_option("--vehicle-believed", options->believed,
                 "vehicle file that was believed so far: its numbers are compared with those found");
  app.add_option(
      "--forecast", options->forecast,
      "JSON of m100-lab excite: the effects that the flight was designed to show, compared with those found");
  app.add_option("--json", options->json, "file for the result as JSON");
  app.add_option("--report", options->report, "folder for the HTML report, and the numbers of its figures as CSV");
  app.add_option("--refits,--draws", options->refits,
                 "number of refits with some blocks left out, for the intervals: at most 40; 0: no intervals")
      .in_range(0, 10000);
}

}  // namespace m100::lab
