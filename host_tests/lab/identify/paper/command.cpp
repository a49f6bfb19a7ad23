// SPDX-License-Identifier: BSD-3-Clause
// m100-lab paper: reproduces the paper's identified numbers from the paper's own logs, and shows what correct alignment
// changes.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "firmware/companion/files/file_use.h"
#include "host_tests/lab/identify/paper/paper_report.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/subcommands.h"

namespace m100::lab {
namespace {

struct PaperOptions {
  std::string pitch_roll, height, yaw, json;
};

void run(const PaperOptions& options) {
  companion::FileUse()
      .reads("--pitch-roll", options.pitch_roll)
      .reads("--height", options.height)
      .reads("--yaw", options.yaw)
      .writes("--json", options.json)
      .check();
  identify::paper::Report report = identify::paper::reproduce(options.pitch_roll, options.height);
  if (!options.yaw.empty()) {
    identify::paper::add_yaw(report, options.yaw);
  }
  std::printf("%-48s %12s %12s %12s\n", "", "paper", "reproduced", "aligned");
  nlohmann::ordered_json lines = nlohmann::ordered_json::array();
  for (const identify::paper::ReproducedNumber& line : report.lines) {
    std::printf("%-48s ", line.quantity.c_str());
    if (std::isfinite(line.paper)) {
      std::printf("%12.4g", line.paper);
    } else {
      std::printf("%12s", "-");
    }
    std::printf(" %12.4g %12.4g\n", line.reproduced, line.aligned);
    lines.push_back(
        {{"quantity", line.quantity},
         {"paper", std::isfinite(line.paper) ? nlohmann::ordered_json(line.paper) : nlohmann::ordered_json()},
         {"reproduced", line.reproduced},
         {"aligned", line.aligned}});
  }
  std::printf("the sticks are %d samples early in the authors' tables, by %s\n", report.stick_shift_samples,
              report.evidence.c_str());
  write_json(options.json, nlohmann::ordered_json{{"lines", std::move(lines)},
                                                  {"stick_shift_samples", report.stick_shift_samples},
                                                  {"evidence", report.evidence}});
}

}  // namespace

void add_paper(CLI::App& lab) {
  CLI::App* app =
      lab.add_subcommand("paper", "reproduce the paper's scale factors and climb dynamics from its own logs");
  auto options = std::make_shared<PaperOptions>();
  app->add_option("--pitch-roll", options->pitch_roll, "ExperimentPitchRoll.mat")->required();
  app->add_option("--height", options->height, "ExperimentHeight.mat")->required();
  app->add_option("--yaw", options->yaw, "ExperimentYaw.mat: adds the yaw rate");
  app->add_option("--json", options->json, "file for the table as JSON");
  app->callback([options] { run(*options); });
}

}  // namespace m100::lab
