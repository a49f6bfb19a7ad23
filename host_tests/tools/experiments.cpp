// SPDX-License-Identifier: BSD-3-Clause
// m100-lab experiments: the paper's tasks, flown by the whole program against the emulated autopilot.
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/sim/plant_file.h"
#include "host_tests/tools/experiments/results.h"
#include "host_tests/tools/input_error.h"
#include "host_tests/tools/subcommands.h"

namespace m100::tools {
namespace {

struct Options {
  std::string plant;
  std::string vehicle;
  std::string only;
  std::uint64_t seed = 1;
  int seeds = 1;
  std::string channel = "virtual_rc";
  bool paper_100_hz = false;
  std::string report;
  std::string json;
};

experiments::SuiteOptions suite_of(const Options& options) {
  experiments::SuiteOptions suite;
  suite.plant = options.plant.empty() ? sim::measured_plant() : sim::load_plant(options.plant);
  suite.vehicle = options.vehicle.empty() ? app::as_file(mpc::generated::kVehicle) : app::load_vehicle(options.vehicle);
  suite.only = options.only;
  suite.seed = options.seed;
  suite.seeds = options.seeds;
  suite.channel = options.channel == "movement" ? app::Channel::kMovement : app::Channel::kVirtualRc;
  suite.paper_100_hz = options.paper_100_hz;
  suite.progress = [](const std::string& line) { std::cerr << line << "\n"; };
  return suite;
}

void run(const Options& options) {
  const std::vector<experiments::TaskResult> results = experiments::fly_suite(suite_of(options));
  experiments::print_table(std::cout, results);
  if (!options.json.empty()) {
    std::ofstream file(options.json);
    file << experiments::to_json(results).dump(2) << "\n";
    if (!file) {
      throw InputError(options.json, 0, "", "cannot be written");
    }
  }
  if (!options.report.empty()) {
    experiments::write_report(
        options.report, results,
        "All numbers here are simulated: the flight program over the emulated wire, autopilot and "
        "aircraft. Plant: " +
            (options.plant.empty() ? std::string("the measured one") : options.plant) +
            ", vehicle: " + (options.vehicle.empty() ? std::string("the project's default") : options.vehicle) +
            ", channel: " + options.channel + ", seeds: " + std::to_string(options.seeds) + ".");
    std::cout << "wrote " << options.report << "/experiments.html\n";
  }
}

}  // namespace

void add_experiments(CLI::App& lab) {
  auto options = std::make_shared<Options>();
  CLI::App* command = lab.add_subcommand("experiments", "fly the paper's tasks in simulation, its table beside ours");
  command->add_option("--plant", options->plant, "what the simulated world is (TOML); default: the measured plant");
  command->add_option("--vehicle", options->vehicle, "what the controller believes (TOML); default: the project's");
  command->add_option("--only", options->only, "one task")
      ->check(CLI::IsMember({"hover", "step", "trajectory", "simulator", "step_6m", "step_2m"}));
  command->add_option("--seed", options->seed, "first seed");
  command->add_option("--seeds", options->seeds, "flights per cell, seeds counted up")->check(CLI::Range(1, 1000));
  command->add_option("--channel", options->channel, "how commands reach the autopilot")
      ->check(CLI::IsMember({"virtual_rc", "movement"}));
  command->add_flag("--paper-100-hz", options->paper_100_hz, "the paper's command rate, beyond what DJI allows");
  command->add_option("--report", options->report, "folder for the page with figures");
  command->add_option("--json", options->json, "file for the numbers");
  command->callback([options] { run(*options); });
}

}  // namespace m100::tools
