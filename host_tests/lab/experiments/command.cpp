// SPDX-License-Identifier: BSD-3-Clause
// m100-lab experiments: flies the paper's tasks with the whole program against the emulated autopilot.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/suggestion.h"
#include "firmware/companion/mode_option.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/body_options.h"
#include "host_tests/lab/experiments/far.h"
#include "host_tests/lab/experiments/report.h"
#include "host_tests/lab/flight/page.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/option_words.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/sim/body/body_plant.h"

namespace m100::lab {
namespace {

struct ExperimentsOptions {
  std::string plant;
  std::string plant_from;
  std::string vehicle;
  std::string only;
  std::uint64_t seed = 1;
  int seeds = 1;
  std::string channel = "virtual_rc";
  double rate_hz = 0.0;
  bool paper_100_hz = false;
  std::string tasks = "paper";
  std::string law = "mpc";
  std::string mode = "field";
  bool baseline = false;
  std::string report;
  std::string json;
  sim::BodyChoice body;
};

link::Channel channel_of(const ExperimentsOptions& options) {
  return options.channel == "movement" ? link::Channel::kMovement : link::Channel::kVirtualRc;
}

experiments::SuiteOptions suite_of(const ExperimentsOptions& options) {
  experiments::SuiteOptions suite;
  suite.plan.plant = sim::plant_of_options(options.body, options.plant, options.plant_from);
  suite.plan.vehicle = companion::in_mode(
      options.vehicle.empty() ? companion::as_file(mpc::generated::kVehicle) : companion::load_vehicle(options.vehicle),
      mode_of(options.mode));
  suite.only = options.only;
  suite.seed = options.seed;
  suite.seeds = options.seeds;
  suite.plan.channel = channel_of(options);
  suite.plan.rate_hz = options.rate_hz;
  suite.plan.paper_100_hz = options.paper_100_hz;
  suite.plan.law = law_of(options.law);
  suite.paper_law = options.law == kPaperLaw;
  suite.baseline = options.baseline;
  suite.progress = [](const std::string& line) { std::cerr << line << "\n"; };
  return suite;
}

/// Checks the files before the flights, which take minutes.
void check_files(const ExperimentsOptions& options) {
  companion::FileUse()
      .reads("--plant", options.plant)
      .reads("--plant-from", options.plant_from)
      .reads("--vehicle", options.vehicle)
      .writes("--json", options.json)
      .fills("--report", options.report, "experiments.html")
      .check();
}

std::string about(const ExperimentsOptions& options) {
  return "All numbers here are simulated: the flight program over the emulated wire, autopilot and aircraft. Plant: " +
         (options.plant.empty() ? std::string("the measured one") : options.plant) +
         (options.plant_from.empty() ? "" : ", on the axes of " + options.plant_from) +
         ", vehicle: " + (options.vehicle.empty() ? std::string("the project's default") : options.vehicle) +
         ", channel: " + options.channel + ", law: " + options.law + ", mode: " + options.mode +
         ", seeds: " + std::to_string(options.seeds) + "." +
         (options.body.is_identified()
              ? ""
              : " The physics is another program's, and so is the air: no fan, the plant's wind in the tasks in wind.");
}

/// The kind of run that the options select, one of two.
struct Kind {
  const char* words;                  ///< as typed on the command line
  std::vector<const char*> not_its;   ///< options that this kind would ignore
  std::vector<std::string> has_only;  ///< the names that --only accepts
};

Kind kind_of(const ExperimentsOptions& options) {
  if (options.tasks == "far") {
    Kind far{"--tasks far", {"--law", "--report", "--baseline", "--paper-100-hz", "--body", "--body-command"}, {}};
    for (const experiments::FarTask& task : experiments::far_tasks()) {
      far.has_only.push_back(task.name);
    }
    return far;
  }
  Kind paper{"--tasks paper", {}, {}};
  for (const auto* const tasks : {&experiments::paper_tasks(), &experiments::literal_steps()}) {
    for (const experiments::Task& task : *tasks) {
      paper.has_only.push_back(task.task);
    }
  }
  return paper;
}

/// Refuses an option that would be ignored, a task that the set does not have, and a rate outside the channel's window.
void check_together(const companion::Subcommand& command, const ExperimentsOptions& options) {
  const Kind kind = kind_of(options);
  for (const char* const option : kind.not_its) {
    if (command.is_given(option)) {
      throw InputError(option, 0, "", std::string("cannot be combined with ") + kind.words);
    }
  }
  if (!options.only.empty() &&
      std::find(kind.has_only.begin(), kind.has_only.end(), options.only) == kind.has_only.end()) {
    throw InputError(
        "--only", 0, options.only,
        std::string("is not a task of ") + kind.words + companion::did_you_mean(options.only, kind.has_only));
  }
  if (options.law == kPaperLaw && (command.is_given("--mode") || options.baseline)) {
    throw InputError(options.baseline ? "--baseline" : "--mode", 0, "", "cannot be combined with --law paper");
  }
  const link::ChannelConfig channel{.channel = channel_of(options), .rate_hz = options.rate_hz};
  if (!link::command_period(channel)) {
    throw InputError("--rate", 0, "", "outside the window of the channel: virtual_rc 5 to 25 Hz, movement 1 to 50 Hz");
  }
}

/// Ends the program with exit code kAnswerIsNo unless all flights were flown; call it after everything is written.
void exit_unless(bool all_flown) {
  if (!all_flown) {
    std::cerr << "m100-lab: some flights never obtained control: they were not flown and are left out of the means\n";
    throw companion::AnswerIsNo();
  }
}

void run_far(const ExperimentsOptions& options) {
  const std::vector<experiments::FarResult> results = experiments::fly_far(suite_of(options));
  experiments::print_far(std::cout, results);
  write_json(options.json, experiments::far_to_json(results).sorted(), 2);
  exit_unless(experiments::not_flown(results) == 0);
}

/// Processor time [s] of this program and of those that it started and that have ended.
double processor_s() {
  double out = 0.0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage used{};
    ::getrusage(who, &used);
    for (const timeval& time : {used.ru_utime, used.ru_stime}) {
      out += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    }
  }
  return out;
}

void print_body(const std::vector<experiments::TaskResult>& results, double used_s) {
  double simulated_s = 0.0;
  for (const experiments::TaskResult& result : results) {
    simulated_s += result.simulated_s;
  }
  std::cout << "The physics is another program's, and so is the air: no fan blew, but the plant's wind in the tasks in "
               "wind.\n"
            << std::lround(simulated_s) << " s flown in " << std::lround(used_s)
            << " s of processor time (with --body-command both programs, taking off included): "
            << std::lround(simulated_s / used_s) << " times real time\n";
}

void run(const ExperimentsOptions& options) {
  experiments::SuiteOptions suite = suite_of(options);
  std::optional<sim::BodyJob> body(options.body);
  suite.plan.body = options.body.is_identified() ? nullptr : &*body;
  std::vector<std::string> pages;
  if (!options.report.empty()) {
    suite.keep_log = [&](const experiments::Task& task, std::string log) {
      const std::string name = task.task + "_" + task.condition;
      pages.push_back(options.report + "/" + experiments::page_name(task));
      const flight::FlightSeries flown =
          flight::series_of(companion::parse_flight_log(std::move(log), name), name, nullptr);
      flight::flight_page({flown}, "Flight: " + task.task + ", " + task.condition, about(options)).write(pages.back());
    };
  }
  const double before_s = processor_s();
  const std::vector<experiments::TaskResult> results = experiments::fly_suite(suite);
  body.reset();  // the processor time of a child is known when it has ended
  experiments::print_table(std::cout, results);
  if (suite.plan.body != nullptr) {
    print_body(results, processor_s() - before_s);
  }
  write_json(options.json, experiments::to_json(results).sorted(), 2);
  if (!options.report.empty()) {
    experiments::write_report(options.report, results, about(options));
    std::cout << "wrote " << printable(options.report) << "/experiments.html, and a page for each flight: "
              << printable(pages.empty() ? "none was flown" : pages.front()) << (pages.size() > 1 ? ", ..." : "")
              << "\n";
  }
  exit_unless(std::all_of(results.begin(), results.end(),
                          [](const auto& result) { return result.refused + result.baselines_refused == 0; }));
}

}  // namespace

void add_experiments(companion::CommandLine& lab) {
  auto options = std::make_shared<ExperimentsOptions>();
  const companion::Subcommand command = lab.add_subcommand(
      "experiments", "fly the paper's tasks in simulation and compare the results with the paper's table");
  command.add_option("--plant", options->plant,
                     "plant file of the simulated world (TOML); default: the measured plant");
  command.add_option(
      "--plant-from", options->plant_from,
      "vehicle file that gives the world its axes, drag and thrust instead of the measured ones; --plant lists the "
      "differences from it");
  command.add_option("--vehicle", options->vehicle,
                     "vehicle file that the controller uses (TOML); default: the project's");
  command
      .add_option("--tasks", options->tasks,
                  "paper: the tasks of the paper; far: five tasks in which the limits are active, each with both laws "
                  "(without --law, --report, --baseline and --paper-100-hz)")
      .one_of({"paper", "far"});
  command.add_option("--only", options->only, "fly only this task")
      .one_of({"hover", "step", "trajectory", "simulator", "step_6m", "step_2m", "step_10m_tail_wind", "step_30m",
               "square_3m", "brake_at_fence"});
  command.add_option("--seed", options->seed, "first seed").whole_number();
  command.add_option("--seeds", options->seeds, "flights per cell, each with the next seed").in_range(1, 1000);
  command.add_option("--channel", options->channel, "how commands reach the autopilot")
      .one_of({"virtual_rc", "movement"});
  command.add_option("--rate", options->rate_hz, "commands per second [Hz]; default: the channel's highest");
  command.add_flag("--paper-100-hz", options->paper_100_hz,
                   "use the paper's command rate, which is higher than DJI allows");
  command
      .add_option(
          "--law", options->law,
          "control law; lqr: the clipped baseline; paper: the law and configuration of the paper's authors, at 100 "
          "commands a second")
      .one_of({"mpc", "lqr", "paper"});
  companion::add_mode_option(command, options->mode, "tuning");
  command.add_flag("--baseline", options->baseline,
                   "fly each task with the clipped LQR and with --law paper too, and show the results");
  add_body_options(command, options->body);
  command.add_option("--report", options->report, "folder for the page with figures");
  command.add_option("--json", options->json, "file for the numbers");
  command.callback([options, command] {
    check_together(command, *options);
    check_files(*options);
    options->body.check();
    options->tasks == "far" ? run_far(*options) : run(*options);
  });
}

}  // namespace m100::lab
