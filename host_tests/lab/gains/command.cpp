// SPDX-License-Identifier: BSD-3-Clause
// m100-lab gains: gain tables of a vehicle file, and what they promise.
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/gains/margins.h"
#include "host_tests/lab/gains/write_tables.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab {
namespace {

struct Options {
  std::string vehicle;
  std::string header;
  std::string table;
  std::string json;
  std::string tuned;
  std::vector<double> box;
  std::vector<std::string> rivals;
  bool corners = false;
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

/// The loop as it flies, on the vehicle file's own structure and on others that its log allows as well.
struct Structure {
  std::string name;
  model::Vehicle vehicle;
};

/// Gain and frequency of a structure are known to a fifth.
constexpr std::array<double, 3> kCorners{1.0, 0.8, 1.2};

model::Vehicle corner(model::Vehicle vehicle, double gain, double frequency) {
  for (model::StickAxis* axis : {&vehicle.roll, &vehicle.pitch}) {
    axis->scale_per_count *= gain;
    axis->natural_frequency_rad_s *= frequency;
    axis->time_constant_s /= frequency;
  }
  return vehicle;
}

nlohmann::json report_flown_axis(const model::Vehicle& believed, const Structure& structure, const char* name,
                                 gains::Axis axis, bool corners) {
  nlohmann::json out;
  for (const auto& [channel, way] :
       {std::pair{"virtual_rc", &gains::kVirtualRcWay}, {"movement", &gains::kMovementWay}}) {
    const gains::Margins margins = gains::flown_margins_of(believed, structure.vehicle, axis, *way);
    std::printf("as flown on %s, %s, %s: %s, peak sensitivity %.2f, gain margin %.2f, delay margin %.0f ms\n",
                structure.name.c_str(), channel, name, margins.stable ? "stable" : "UNSTABLE", margins.peak_sensitivity,
                margins.gain_margin, margins.delay_margin_s * 1e3);
    out[channel] = margins_json(margins);
  }
  if (!corners) {
    return out;
  }
  gains::Margins worst{.stable = true, .delay_margin_s = gains::kLargestDelay_s};
  std::array<double, 2> most_sensitive{1.0, 1.0};
  std::array<double, 2> least_delay{1.0, 1.0};
  for (const double gain : kCorners) {
    for (const double frequency : kCorners) {
      const gains::Margins margins =
          gains::flown_margins_of(believed, corner(structure.vehicle, gain, frequency), axis, gains::kVirtualRcWay);
      worst.stable = worst.stable && margins.stable;
      if (margins.peak_sensitivity > worst.peak_sensitivity) {
        worst.peak_sensitivity = margins.peak_sensitivity;
        most_sensitive = {gain, frequency};
      }
      if (margins.delay_margin_s < worst.delay_margin_s) {
        worst.delay_margin_s = margins.delay_margin_s;
        least_delay = {gain, frequency};
      }
    }
  }
  const bool kept = worst.stable && worst.peak_sensitivity <= gains::kLargestPeakSensitivity &&
                    worst.delay_margin_s >= gains::kFieldDelayMargin_s;
  std::printf(
      "  over gain and frequency +-20 %%, virtual_rc, %s: %speak sensitivity %.2f (gain x %.1f, frequency x %.1f), "
      "delay "
      "margin %.0f ms (gain x %.1f, frequency x %.1f)%s\n",
      name, worst.stable ? "" : "UNSTABLE in a corner, ", worst.peak_sensitivity, most_sensitive[0], most_sensitive[1],
      worst.delay_margin_s * 1e3, least_delay[0], least_delay[1], kept ? "" : ": NOT KEPT");
  out["corners"] = {{"stable", worst.stable},
                    {"peak_sensitivity", worst.peak_sensitivity},
                    {"delay_margin_s", worst.delay_margin_s},
                    {"kept", kept}};
  return out;
}

nlohmann::json report_flown(const model::Vehicle& believed, const std::vector<std::string>& rivals, bool corners) {
  std::vector<Structure> structures{{"its own structure", believed}};
  for (const std::string& path : rivals) {
    structures.push_back({path, companion::load_vehicle(path).vehicle});
  }
  nlohmann::json out;
  bool kept = true;
  for (const Structure& structure : structures) {
    for (const auto& [name, axis] : {std::pair{"x", gains::Axis::kX}, {"y", gains::Axis::kY}}) {
      nlohmann::json& cell = out[structure.name][name] = report_flown_axis(believed, structure, name, axis, corners);
      kept = kept && (!corners || cell["corners"]["kept"].get<bool>());
    }
  }
  if (!kept) {
    std::printf(
        "warning: as flown, not every corner keeps a peak sensitivity of %.1f and %.0f ms of delay\n"
        "To tell the structures apart, fly sticks that jump (m100-lab excite --kind doublet) with the gyro logged: a "
        "lead "
        "zero turns the aircraft in the sample of the jump, a pure delay does not.\n",
        gains::kLargestPeakSensitivity, gains::kFieldDelayMargin_s * 1e3);
  }
  return out;
}

/// Prints what the loop stands and warns below the limits; refuses nothing.
void report_margins(const model::Vehicle& vehicle, const Options& options) {
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
  all["flown"] = report_flown(vehicle, options.rivals, options.corners);
  all["weights"] = {{"position", vehicle.mpc.position},
                    {"velocity", vehicle.mpc.velocity},
                    {"tilt", vehicle.mpc.tilt},
                    {"input", vehicle.mpc.input},
                    {"input_rate", vehicle.mpc.input_rate}};
  if (!options.json.empty()) {
    std::ofstream stream(options.json);
    stream << all.dump(1) << "\n";
    if (!stream.flush()) {
      throw InputError(options.json, 0, "", "cannot be written");
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

/// Before the work: every output has a place, and none is the file that is read.
void check_outputs(const Options& options) {
  const std::array<std::pair<const std::string*, const char*>, 4> outputs{
      {{&options.header, "--out"}, {&options.table, "--table"}, {&options.json, "--json"}, {&options.tuned, "--tune"}}};
  for (const auto& [file, option] : outputs) {
    refuse_overwriting(options.vehicle, *file, option);
    if (!options.check || file == &options.tuned) {
      require_writable(*file, option);
    }
  }
}

void run(const Options& options) {
  check_outputs(options);
  companion::VehicleFile file = companion::load_vehicle(options.vehicle);
  gains::TableSet set{};
  try {
    if (!options.tuned.empty()) {
      file.vehicle.mpc = gains::tuned_weights(file.vehicle);
      file = companion::save_vehicle(options.tuned, file.vehicle, file.sources);
      std::printf("input weight %.3g: the fastest loop that keeps the limits\n", file.vehicle.mpc.input);
    }
    if (!options.check) {
      report_margins(file.vehicle, options);
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
  command->add_option("--rival", options->rivals,
                      "vehicle file of a structure that the log allows as well: margins on it too; may be repeated");
  command->add_option("--tune", options->tuned,
                      "chooses the input weight, writes this vehicle file and makes the tables from it");
  command
      ->add_option("--setpoint-box", options->box,
                   "where the set-point law holds: position error [m], velocity [m/s], tilt [rad], tilt rate [rad/s], "
                   "previous input [rad], steady input [rad]; 6 4 0.5 2 0.75 0.31 unless told")
      ->expected(6)
      ->check(CLI::PositiveNumber);
  command->add_flag("--corners", options->corners, "as flown, over gain and frequency +-20 % of every structure");
  command->add_flag("--check", options->check, "compare with the files that are there instead of writing them");
  command->callback([options] { run(*options); });
}

}  // namespace m100::lab
