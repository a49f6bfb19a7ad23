// SPDX-License-Identifier: BSD-3-Clause
// m100-lab paper: reproduces the paper's numbers from its own logs, and shows what correct alignment changes.
#include <cmath>
#include <cstdio>
#include <memory>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/model/default_vehicle.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/identify/paper/configuration.h"
#include "host_tests/lab/identify/paper/paper_report.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/subcommands.h"

namespace m100::lab {
namespace {

struct PaperOptions {
  std::string pitch_roll, height, yaw, configuration, json;
};

/// Writes the vehicle file, and prints where each of its numbers comes from, as rows of a Markdown table.
void write_configuration(const std::string& path) {
  const model::Vehicle flown = model::paper_configuration(mpc::generated::kVehicle);
  companion::save_vehicle(path, flown,
                          {{"axis.roll", "paper, Table I, Table II, III-B.5"},
                           {"axis.pitch", "paper, Table I, Table II, III-B.5"},
                           {"axis.yaw_rate", "paper, Table I, III-D.3, III-B.5"},
                           {"axis.climb", "paper, Table I, III-D.3, III-B.5"}});
  for (const identify::paper::ConfigurationRow& row : identify::paper::configuration_rows(flown)) {
    std::printf("| %s | %s | %s | %s |\n", row.what.c_str(), row.printed.c_str(), row.published.c_str(),
                row.flown.c_str());
  }
}

void check_files(const PaperOptions& options) {
  companion::FileUse()
      .reads("--pitch-roll", options.pitch_roll)
      .reads("--height", options.height)
      .reads("--yaw", options.yaw)
      .writes("--configuration", options.configuration)
      .writes("--json", options.json)
      .check();
}

void run(const PaperOptions& options) {
  identify::paper::Report report = identify::paper::reproduce(options.pitch_roll, options.height);
  if (!options.yaw.empty()) {
    identify::paper::add_yaw(report, options.yaw);
  }
  std::printf("%-66s %12s %12s %12s\n", "", "paper", "reproduced", "aligned");
  const auto or_none = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
  Json lines = Json::array();
  for (const identify::paper::ReproducedNumber& line : report.lines) {
    std::printf("%-66s", line.quantity.c_str());
    for (const double value : {line.paper, line.reproduced, line.aligned}) {
      std::isfinite(value) ? std::printf(" %12.4g", value) : std::printf(" %12s", "-");
    }
    std::printf("  %s\n", verdict(line).c_str());
    lines.push_back({{"quantity", line.quantity},
                     {"paper", or_none(line.paper)},
                     {"reproduced", or_none(line.reproduced)},
                     {"aligned", or_none(line.aligned)},
                     {"verdict", verdict(line)}});
  }
  std::printf("the sticks are %d samples early in the authors' tables, by %s\n", report.stick_shift_samples,
              report.evidence.c_str());
  write_json(options.json, Json{{"lines", std::move(lines)},
                                {"stick_shift_samples", report.stick_shift_samples},
                                {"evidence", report.evidence}});
}

}  // namespace

void add_paper(companion::CommandLine& lab) {
  const companion::Subcommand app =
      lab.add_subcommand("paper", "reproduce the numbers of the paper's Tables I and II from its own logs");
  auto options = std::make_shared<PaperOptions>();
  const companion::Option tilt = app.add_option("--pitch-roll", options->pitch_roll, "ExperimentPitchRoll.mat");
  app.add_option("--height", options->height, "ExperimentHeight.mat").needs("--pitch-roll");
  tilt.needs("--height");
  app.add_option("--yaw", options->yaw, "ExperimentYaw.mat: adds the yaw rate").needs("--pitch-roll");
  app.add_option("--json", options->json, "file for the table as JSON").needs("--pitch-roll");
  app.add_option(
      "--configuration", options->configuration,
      "writes the axes and weights of --law paper as a vehicle file, and prints where its numbers come from");
  app.callback([options] {
    if (options->pitch_roll.empty() && options->configuration.empty()) {
      throw InputError("--pitch-roll", 0, "", "is missing: give both logs, or --configuration");
    }
    check_files(*options);
    if (!options->pitch_roll.empty()) {
      run(*options);
    }
    if (!options->configuration.empty()) {
      write_configuration(options->configuration);
    }
  });
}

}  // namespace m100::lab
