// SPDX-License-Identifier: BSD-3-Clause
// m100-lab loop: fly, identify the effects that the vehicle file lacks, add them, make new tables, fly again.
#include <filesystem>
#include <fstream>
#include <iostream>
#include <tuple>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/suggestion.h"
#include "firmware/companion/files/vehicle_keys.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/body_options.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/loop/aligned_log.h"
#include "host_tests/lab/loop/close_loop.h"
#include "host_tests/lab/loop/model_comparison.h"
#include "host_tests/lab/loop/page.h"
#include "host_tests/lab/loop/results.h"
#include "host_tests/lab/option_words.h"
#include "host_tests/lab/printable.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/sim/body/body_plant.h"

namespace m100::lab {
namespace {

struct LoopOptions {
  std::string plant;
  std::string plant_from;
  std::string vehicle;
  std::string out;
  std::string json;
  std::string logs;
  std::string report;
  std::uint64_t seed = 1;
  int seeds = 5;
  std::string law = "mpc";
  std::string tasks = "hover,step,trajectory";
  std::vector<std::string> models;
  bool keep_worse = false;
  sim::BodyChoice body;
};

/// Checks the files before the flights, which take minutes.
void check_files(const LoopOptions& options) {
  companion::FileUse()
      .reads("--plant", options.plant)
      .reads("--plant-from", options.plant_from)
      .reads("--vehicle", options.vehicle)
      .reads("--models", options.models)
      .writes("--out", options.out)
      .writes("--json", options.json)
      .fills("--logs", options.logs, "columns.toml")
      .fills("--report", options.report, "loop.html")
      .check();
}

/// Compares vehicle files on one plant instead of closing the loop.
void run_models(const LoopOptions& options, const loop::LoopOptions& loop) {
  if (options.plant_from.empty() || !options.plant.empty() || loop.plan.body != nullptr) {
    throw InputError("--models", 0, "", "needs --plant-from, and neither --plant nor --body");
  }
  std::vector<loop::ComparedModel> models;
  for (const std::string& file : options.models) {
    models.push_back({std::filesystem::path(file).stem().string(), companion::load_vehicle(file)});
  }
  const std::vector<loop::ModelScore> scores =
      loop::compare_models(loop, models, companion::load_vehicle(options.plant_from).vehicle);
  loop::print(std::cout, scores);
  write_json(options.json, loop::to_json(scores).sorted(), 2);
}

/// Every number of an axis that the world or the vehicle file has; "without": of an axis that lacks the effect.
Json axis_numbers(const model::StickAxis& world, const model::StickAxis& vehicle, model::AxisUnit unit) {
  const model::StickAxis neutral;
  Json out = Json::object();
  for (const companion::NumberKey<model::StickAxis>& key : companion::axis_keys(unit)) {
    const double in_world = world.*key.member;
    const double in_file = vehicle.*key.member;
    const double without = neutral.*key.member;
    if (in_world != without || in_file != without) {
      out[std::string(key.key)] = {{"world", in_world}, {"vehicle", in_file}, {"without", without}};
    }
  }
  return out;
}

void run(const LoopOptions& options) {
  if (options.out.empty() && options.models.empty()) {
    throw InputError("--out", 0, "", "is missing: give the vehicle file to write");
  }
  check_files(options);
  if (!options.out.empty() && !options.models.empty()) {
    throw InputError("--models", 0, "", "cannot be combined with --out: it identifies nothing");
  }
  options.body.check();
  loop::LoopOptions loop;
  if (options.plant.empty() && options.plant_from.empty() && options.body.is_identified()) {
    throw InputError("--plant", 0, "",
                     "is missing: give the plant file of the simulated world, or --plant-from, or a --body");
  }
  loop.plan.plant = sim::plant_of_options(options.body, options.plant, options.plant_from);
  loop.plan.vehicle =
      options.vehicle.empty() ? companion::as_file(mpc::generated::kVehicle) : companion::load_vehicle(options.vehicle);
  loop.seed = options.seed;
  loop.seeds = options.seeds;
  loop.plan.law = law_of(options.law);
  loop.keep_worse = options.keep_worse;
  sim::BodyJob body(options.body);
  loop.plan.body = options.body.is_identified() ? nullptr : &body;
  loop.tasks = options.tasks == "none" ? std::vector<std::string>{} : list_of("--tasks", options.tasks);
  constexpr std::array<std::string_view, 3> kTasks{"hover", "step", "trajectory"};
  for (const std::string& task : loop.tasks) {
    if (std::find(kTasks.begin(), kTasks.end(), task) == kTasks.end()) {
      throw InputError(
          "--tasks", 0, task,
          "is not a task; the tasks are hover, step, trajectory, or none" + companion::did_you_mean(task, kTasks));
    }
  }
  loop.progress = [](const std::string& line) { std::cerr << "  " << line << "\n"; };
  if (!options.logs.empty()) {
    std::filesystem::create_directories(options.logs);
    loop.log_folder = options.logs;
    std::ofstream(options.logs + "/columns.toml") << loop::own_columns();
  }
  if (!options.models.empty()) {
    run_models(options, loop);
    return;
  }
  const loop::LoopResult result = loop::close_loop(loop);
  const companion::VehicleFile& kept = result.is_kept ? result.vehicle : loop.plan.vehicle;
  companion::save_vehicle(options.out, kept);
  loop::print(std::cout, result);
  if (!options.report.empty()) {
    const std::string page = options.report + "/loop.html";
    loop::write_page(result, page);
    std::cout << "wrote " << printable(page) << "\n";
  }
  Json json = loop::to_json(result);
  // For reports only, after the loop is closed: neither controller nor identification see it.
  const auto& [world, flown] = std::tie(loop.plan.plant, loop.plan.vehicle.vehicle);
  json["world"] = {{"roll", axis_numbers(world.roll, flown.roll, model::AxisUnit::kTilt_rad)},
                   {"pitch", axis_numbers(world.pitch, flown.pitch, model::AxisUnit::kTilt_rad)},
                   {"yaw_rate", axis_numbers(world.yaw_rate, flown.yaw_rate, model::AxisUnit::kYawRate_rad_s)},
                   {"climb", axis_numbers(world.climb, flown.climb, model::AxisUnit::kClimb_m_s)}};
  write_json(options.json, json.sorted(), 2);
}

}  // namespace

void add_loop(companion::CommandLine& lab) {
  const auto [command, options] = lab.add_subcommand<LoopOptions>(
      "loop", "fly, identify the effects that the vehicle file lacks, add them, fly again", run);
  command.add_option("--plant", options->plant,
                     "plant file of the simulated world (TOML); only the simulator reads it");
  command.add_option(
      "--plant-from", options->plant_from,
      "vehicle file from which the world takes its axes, drag and thrust instead of the measured ones; the keys of "
      "--plant override it");
  add_body_options(command, options->body);
  command.add_option("--vehicle", options->vehicle,
                     "vehicle file that the controller uses at first; default: the project's");
  command.add_option("--out", options->out,
                     "vehicle file to write: the new one, or the former one if the new one is worse");
  command.add_flag("--keep-worse", options->keep_worse, "write the new vehicle file even if a task is worse as flown");
  command.add_option("--models", options->models,
                     "vehicle files to compare on the aircraft of --plant-from, instead of identifying: prediction, "
                     "errors in flight and margins, each with its interval over the seeds");
  command.add_option("--json", options->json, "file for the numbers");
  command.add_option(
      "--logs", options->logs,
      "folder for the logs of the three identification flights and their column map; default: they are not kept");
  command.add_option("--report", options->report, "folder for the HTML report (loop.html)");
  command.add_option("--tasks", options->tasks, "tasks to fly before and after: any of hover,step,trajectory, or none");
  command.add_option("--law", options->law, "horizontal control law; lqr: the clipped LQR baseline")
      .one_of({"mpc", "lqr"});
  command.add_option("--seed", options->seed, "first seed").whole_number();
  command.add_option("--seeds", options->seeds, "flights per task and condition, before and after with the same seeds")
      .in_range(2, 100);
}

}  // namespace m100::lab
