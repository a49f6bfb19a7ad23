// SPDX-License-Identifier: BSD-3-Clause
// m100-lab gains: gain tables of a vehicle file, and what they promise.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "firmware/app/vehicle_file.h"
#include "host_tests/tools/gains/gain_tables.h"
#include "host_tests/tools/gains/margins.h"
#include "host_tests/tools/gains/write_tables.h"
#include "host_tests/tools/input_error.h"
#include "host_tests/tools/subcommands.h"

namespace m100::tools {
namespace {

struct Options {
  std::string vehicle;
  std::string header;
  std::string table;
  std::string json;
  std::string tuned;
  bool check = false;
};

std::string margins_text(const char* axis, const gains::Margins& margins) {
  char line[200];
  std::snprintf(line, sizeof line,
                "%s: %s, peak sensitivity %.2f, gain margin %.2f, phase margin %.0f deg, delay margin %.0f ms, "
                "crossover %.1f rad/s",
                axis, margins.stable ? "stable" : "UNSTABLE", margins.peak_sensitivity, margins.gain_margin,
                margins.phase_margin_rad * 57.29577951, margins.delay_margin_s * 1e3, margins.crossover_rad_s);
  return line;
}

nlohmann::json margins_json(const gains::Margins& margins) {
  return {{"stable", margins.stable},
          {"peak_sensitivity", margins.peak_sensitivity},
          {"gain_margin", margins.gain_margin},
          {"phase_margin_rad", margins.phase_margin_rad},
          {"delay_margin_s", margins.delay_margin_s},
          {"crossover_rad_s", margins.crossover_rad_s},
          {"robust", gains::is_robust(margins)}};
}

/// Prints what the loop stands and warns below the limits; refuses nothing.
void report_margins(const model::Vehicle& vehicle, const std::string& json) {
  nlohmann::json all;
  for (const auto& [name, axis] : {std::pair{"x", gains::Axis::kX}, {"y", gains::Axis::kY}}) {
    const gains::Margins margins = gains::margins_of(vehicle, axis);
    std::printf("%s\n", margins_text(name, margins).c_str());
    if (!gains::is_robust(margins)) {
      std::printf(
          "warning: axis %s is below the limits (peak sensitivity at most %.1f, delay margin at least %.0f ms)\n", name,
          gains::kLargestPeakSensitivity, gains::kSmallestDelayMargin_s * 1e3);
    }
    all["margins"][name] = margins_json(margins);
  }
  all["weights"] = {{"position", vehicle.mpc.position},
                    {"velocity", vehicle.mpc.velocity},
                    {"tilt", vehicle.mpc.tilt},
                    {"input", vehicle.mpc.input},
                    {"input_rate", vehicle.mpc.input_rate}};
  if (!json.empty()) {
    std::ofstream stream(json);
    stream << all.dump(1) << "\n";
    if (!stream.flush()) {
      throw InputError(json, 0, "", "cannot be written");
    }
  }
}

/// Writes the bytes, or with `check` compares them with what is there. @returns false when they differ.
bool put(const std::string& path, std::string_view bytes, bool check) {
  if (check) {
    std::ifstream stream(path, std::ios::binary);
    const std::string there((std::istreambuf_iterator<char>(stream)), {});
    if (!stream || there != bytes) {
      std::fprintf(stderr, "m100-lab: %s: is not what this vehicle file gives\n", path.c_str());
      return false;
    }
    return true;
  }
  std::ofstream stream(path, std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.flush();
  if (!stream) {
    throw InputError(path, 0, "", "cannot be written");
  }
  return true;
}

void run(const Options& options) {
  app::VehicleFile file = app::load_vehicle(options.vehicle);
  gains::TableSet set{};
  try {
    if (!options.tuned.empty()) {
      file.vehicle.mpc = gains::tuned_weights(file.vehicle);
      file = app::save_vehicle(options.tuned, file.vehicle, file.sources);
      std::printf("input weight %.3g: the fastest loop that keeps the limits\n", file.vehicle.mpc.input);
    }
    if (!options.check) {
      report_margins(file.vehicle, options.json);
    }
    set = gains::make_table_set(file);
  } catch (const std::domain_error& wrong) {
    throw InputError(options.vehicle, 0, "axis", wrong.what());
  }
  bool same = true;
  if (!options.header.empty()) {
    same = put(options.header, gains::to_header(set, file.vehicle), options.check) && same;
  }
  if (!options.table.empty()) {
    const std::vector<std::byte> bytes = gains::to_file(set);
    same = put(options.table, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, options.check) && same;
  }
  if (!same) {
    throw CLI::RuntimeError(kAnswerIsNo);
  }
}

}  // namespace

void add_gains(CLI::App& lab) {
  CLI::App* command = lab.add_subcommand("gains", "makes the controller's tables from a vehicle file");
  auto options = std::make_shared<Options>();
  command->add_option("--vehicle", options->vehicle, "vehicle file (TOML)")->required();
  command->add_option("--out", options->header, "C++ header for the firmware");
  command->add_option("--table", options->table, "gain table file for `m100 fly`");
  command->add_option("--json", options->json, "margins as JSON");
  command->add_option("--tune", options->tuned,
                      "chooses the input weight, writes this vehicle file and makes the tables from it");
  command->add_flag("--check", options->check, "compare with the files that are there instead of writing them");
  command->callback([options] { run(*options); });
}

}  // namespace m100::tools
