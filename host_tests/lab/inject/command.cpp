// SPDX-License-Identifier: BSD-3-Clause
// m100-lab inject: adds an effect to a measured flight, to test whether the analysis finds it.
#include <cmath>
#include <iostream>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/selection/problem.h"
#include "host_tests/lab/inject/inject.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/logs/write_csv.h"
#include "host_tests/lab/option_words.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/printed.h"
#include "host_tests/lab/subcommands.h"

namespace m100::lab {
namespace {

struct InjectOptions {
  std::string log, columns, axis, declare = "second_order", train, effect, out, map, json;
};

hidden::HiddenEffects effects_of(const std::string& text, const std::string& axis) {
  hidden::HiddenEffects out;
  for (const std::string& one : list_of("--effect", text)) {
    const std::vector<std::string> halves = parts(one, '=');
    if (halves.size() != 2) {
      throw InputError("--effect", 0, one, "must be NAME=VALUE");
    }
    const std::optional<model::Bounds> range = hidden::addable(halves[0], axis);
    if (!range) {
      throw InputError("--effect", 0, halves[0],
                       "is not an effect that can be added to " + axis + identify::effect_meant(halves[0]));
    }
    const double value = number("--effect", halves[1]);
    if (value < range->low || value > range->high) {
      throw InputError("--effect", 0, one, printed("is outside [%g, %g]", range->low, range->high));
    }
    if (!out.emplace(halves[0], value).second) {
      throw InputError("--effect", 0, halves[0], "is named twice");
    }
  }
  return out;
}

void write_answer(const InjectOptions& options, const identify::ModelResult& fitted,
                  const hidden::HiddenEffects& effects) {
  Json parameters = Json::object();
  for (const identify::NamedValue& one : fitted.parameters) {
    parameters[one.name] = one.value;
  }
  write_json(options.json,
             Json{{"log", options.log},
                  {"out", options.out},
                  {"axis", options.axis},
                  {"effects", effects},
                  {"declared", {{"structure", fitted.structure}, {"parameters", std::move(parameters)}}}});
}

void run(const InjectOptions& options) {
  companion::FileUse()
      .reads("--log", options.log)
      .reads("--columns", options.columns)
      .writes("--out", options.out)
      .writes("--map", options.map)
      .writes("--json", options.json)
      .check();
  const hidden::HiddenEffects effects = effects_of(options.effect, options.axis);
  const logs::FlightLog log = logs::load(options.log, options.columns);
  identify::ModelResult fitted;
  if (options.axis != "translation") {
    identify::Request request;
    request.axis = options.axis;
    request.declared = list_of("--declare", options.declare);
    request.log = &log;
    request.validation_log = &log;
    const std::vector<std::string> ends = parts(options.train, ':');
    if (ends.size() != 2) {
      throw InputError("--train", 0, options.train, "must be FROM:TO in seconds");
    }
    request.train = {{number("--train", ends[0]), number("--train", ends[1])}};
    request.validate = request.train;  // the validation errors are not used
    request.refits = 0;
    fitted = identify::identify_axis(request).declared;
  } else if (!options.train.empty()) {
    throw InputError("--train", 0, options.train, "is not for translation, to which effects are added without a fit");
  }
  const logs::FlightLog out = hidden::inject(log, options.axis, fitted, effects);
  logs::write_csv(out, options.out);
  if (!options.map.empty()) {
    logs::write_column_map(out, options.map);
  }
  std::cout << printable(options.out) << ": " << options.effect << " added to " << options.axis << " of "
            << printable(options.log) << "\n";
  write_answer(options, fitted, effects);
}

}  // namespace

void add_inject(companion::CommandLine& lab) {
  const auto [app, options] =
      lab.add_subcommand<InjectOptions>("inject", "add a named effect to a measured flight and keep its residual", run);
  app.add_option("--log", options->log, "flight log").required();
  app.add_option("--columns", options->columns, "column map (TOML)").required();
  app.add_option("--axis", options->axis, "roll, pitch, yaw_rate, climb or translation")
      .required()
      .one_of({"roll", "pitch", "yaw_rate", "climb", "translation"});
  app.add_option("--declare", options->declare, "model to which the effect is added, as for identify");
  app.add_option("--train", options->train,
                 "FROM:TO in seconds, the part on which that model is fitted; not for translation");
  app.add_option("--effect", options->effect, "NAME=VALUE[,NAME=VALUE...], value in the effect's first unit")
      .required();
  app.add_option("--out", options->out, "CSV to write").required();
  app.add_option("--map", options->map, "also write its column map");
  app.add_option("--json", options->json, "the added effects and the fitted model, as JSON");
}

}  // namespace m100::lab
