// SPDX-License-Identifier: BSD-3-Clause
// m100-lab gains: gain tables of a vehicle file, and what they promise.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
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
  std::vector<double> box;
  bool check = false;
};

/// One line that is written over, when somebody is there to read it.
gains::SetpointProgress progress_line() {
  if (isatty(STDERR_FILENO) == 0) {
    return {};
  }
  return
      [last = std::chrono::steady_clock::time_point{}](std::size_t regions, std::size_t planes, double spent) mutable {
        const auto now = std::chrono::steady_clock::now();
        if (now - last > std::chrono::milliseconds(200)) {
          last = now;
          std::fprintf(stderr, "\rset-point law: %zu regions, %zu planes, %.0f %% of the allowance \r", regions, planes,
                       100.0 * spent);
        }
      };
}

void report_setpoint_law(const char* axis, const gains::SetpointRows& rows) {
  if (rows.too_large) {
    std::printf(
        "%s: the set-point law is too large for a table (given up after %llu linear programs): the preview law "
        "flies alone, as exactly\n",
        axis, static_cast<unsigned long long>(rows.programs));
  } else if (rows.nodes.empty()) {
    std::printf("%s: no set-point law: its limits are not symmetric or too small\n", axis);
  } else {
    std::printf(
        "%s: set-point law of %zu regions in half the box, %zu affine pieces, at most %zu planes in %u nodes of "
        "%zu, %zu bytes in float, %llu linear programs\n",
        axis, rows.regions, rows.pieces, rows.borders, rows.depth, rows.nodes.size(),
        4 * (rows.planes.size() + rows.laws.size()) + sizeof(mpc::SetpointNode) * rows.nodes.size(),
        static_cast<unsigned long long>(rows.programs));
  }
}

/// Ages of the pose that the report gives, in ticks of 10 ms: fresh, as simulated, and the oldest of the paper's link.
constexpr std::array<std::size_t, 3> kPoseAges{0, 2, 8};

std::string margins_text(const char* axis, std::size_t pose_age_ticks, const gains::Margins& margins) {
  char line[240];
  std::snprintf(
      line, sizeof line,
      "%s, pose %zu ms old: %s, peak sensitivity %.2f, gain margin %.2f, phase margin %.0f deg, delay margin %.0f ms, "
      "crossover %.1f rad/s",
      axis, 10 * pose_age_ticks, margins.stable ? "stable" : "UNSTABLE", margins.peak_sensitivity, margins.gain_margin,
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
    for (const std::size_t age : kPoseAges) {
      const gains::Margins margins = gains::margins_of(vehicle, axis, age);
      std::printf("%s\n", margins_text(name, age, margins).c_str());
      if (!gains::is_robust(margins)) {
        std::printf(
            "warning: axis %s is below the limits (peak sensitivity at most %.1f, delay margin at least %.0f ms)\n",
            name, gains::kLargestPeakSensitivity, gains::kSmallestDelayMargin_s * 1e3);
      }
      all[age == 0 ? "margins" : "margins_pose_" + std::to_string(10 * age) + "ms"][name] = margins_json(margins);
    }
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
    gains::SetpointBox box = gains::kSetpointBox;
    std::copy(options.box.begin(), options.box.end(), box.begin());
    set = gains::make_table_set(file, box, progress_line());
    if (!options.check) {
      report_setpoint_law("x", set.x);
      report_setpoint_law("y", set.y);
    }
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
  command
      ->add_option("--setpoint-box", options->box,
                   "where the set-point law holds: position error [m], velocity [m/s], tilt [rad], tilt rate [rad/s], "
                   "previous input [rad], steady input [rad]; 6 4 0.5 2 0.75 0.31 unless told")
      ->expected(6)
      ->check(CLI::PositiveNumber);
  command->add_flag("--check", options->check, "compare with the files that are there instead of writing them");
  command->callback([options] { run(*options); });
}

}  // namespace m100::tools
