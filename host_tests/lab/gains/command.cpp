// SPDX-License-Identifier: BSD-3-Clause
// m100-lab gains: makes the gain tables of a vehicle file, and reports their margins.
#include <unistd.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/mode.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/companion/mode_option.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/gains/margins.h"
#include "host_tests/lab/gains/report_flown.h"
#include "host_tests/lab/gains/report_height_yaw.h"
#include "host_tests/lab/gains/tuning/tune_command.h"
#include "host_tests/lab/gains/write_tables.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/option_words.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab {
namespace {

struct GainsOptions {
  std::string vehicle;
  std::string header;
  std::string table;
  std::string json;
  std::string tuned;
  std::string present;
  std::vector<double> box;
  std::vector<std::string> rivals;
  std::string mode = "field";
  bool corners = false;
  bool check = false;
};

/// A progress line that overwrites itself; only if standard error is a terminal.
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
        "%s: the set-point law is too large for a table (stopped after %llu linear programs): the preview law, which "
        "is as exact, flies alone\n",
        axis, static_cast<unsigned long long>(rows.programs));
  } else if (rows.nodes.empty()) {
    std::printf("%s: no set-point law: the limits are not symmetric or too small\n", axis);
  } else {
    std::printf(
        "%s: set-point law of %zu regions in half the box, %zu affine pieces, at most %zu planes in %u nodes of "
        "%zu, %zu bytes in float, %llu linear programs\n",
        axis, rows.regions, rows.pieces, rows.borders, rows.depth, rows.nodes.size(),
        4 * (rows.planes.size() + rows.laws.size()) + sizeof(mpc::SetpointNode) * rows.nodes.size(),
        static_cast<unsigned long long>(rows.programs));
  }
}

/// Prints the margins and writes them as JSON if a file is given. Margins outside the limits cause only a warning.
void report_margins(const model::Vehicle& vehicle, const std::vector<gains::OpenStructure>& structures,
                    const GainsOptions& options) {
  const gains::MarginLimits& limits =
      mode_of(options.mode) == companion::Mode::kRobust ? gains::kRobustLimits : gains::kFieldLimits;
  Json all = gains::report_flown(vehicle, structures, options.corners ? &limits : nullptr);
  all.update(gains::report_height_yaw(vehicle));
  const model::MpcWeights weights = model::controller_model(vehicle).mpc;
  all["weights"] = {{"position", weights.position},
                    {"velocity", weights.velocity},
                    {"tilt", weights.tilt},
                    {"input", weights.input},
                    {"input_rate", weights.input_rate}};
  write_json(options.json, all.sorted());
}

/// Writes the bytes, or with `check` compares them with the existing file. @returns false: they differ.
bool put(const std::string& path, std::string_view bytes, bool check) {
  if (check) {
    if (whole_file(path) != bytes) {
      std::fprintf(stderr, "m100-lab: %s: differs from the tables that this vehicle file gives\n", path.c_str());
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

/// Checks that each file can be read or written. With --check, the header and the table are only read.
void check_files(const GainsOptions& options) {
  companion::FileUse use;
  use.reads("--vehicle", options.vehicle)
      .reads("--rival", options.rivals)
      .reads("--present", options.present)
      .writes("--tune", options.tuned);
  if (options.check) {
    use.reads("--out", options.header).reads("--table", options.table);
  } else {
    use.writes("--out", options.header).writes("--table", options.table).writes("--json", options.json);
  }
  use.check();
}

/// The structure of the vehicle file, those of its rivals, and that of each file given by --rival.
std::vector<gains::OpenStructure> structures_of(const companion::VehicleFile& file, const GainsOptions& options) {
  std::vector<gains::OpenStructure> structures = gains::open_structures(file);
  for (const std::string& path : options.rivals) {
    structures.push_back(gains::open_structures(companion::load_vehicle(path)).front());
    structures.back().name = path;
  }
  return structures;
}

/// Ends the program at Ctrl-C, before any table is written.
void stop(int) {
  constexpr std::string_view kSaid =
      "\nm100-lab: gains: stopped, no table was written; the same command starts again\n";
  (void)!::write(STDERR_FILENO, kSaid.data(), kSaid.size());
  std::_Exit(companion::kAnswerIsNo);
}

/// Prints on a terminal which stage runs.
void say_stage(const char* stage) {
  if (isatty(STDERR_FILENO) != 0) {
    std::fprintf(stderr, "gains: %s\n", stage);
  }
}

/// The bytes of the table file: the tables of all modes of the vehicle file, one after the other, field first.
std::string table_of_modes(const gains::TableSet& field, const companion::VehicleFile& file,
                           const gains::SetpointBox& box) {
  std::string out;
  const auto append = [&out](const gains::TableSet& set) {
    for (const std::byte byte : gains::to_file(set)) {
      out.push_back(static_cast<char>(byte));
    }
  };
  append(field);
  for (const companion::Mode mode : companion::kModes) {
    if (mode != companion::Mode::kField && companion::has_mode(file, mode)) {
      append(gains::make_table_set(companion::in_mode(file, mode), box, progress_line()));
    }
  }
  return out;
}

/// @returns false: with --check, a file differs
bool write_tables(const companion::VehicleFile& file, const gains::TableSet& set, const std::string& table,
                  const GainsOptions& options) {
  const bool same = options.header.empty() || put(options.header, gains::to_header(set, file.vehicle), options.check);
  return (options.table.empty() || put(options.table, table, options.check)) && same;
}

void run(const GainsOptions& options) {
  check_files(options);
  std::signal(SIGINT, stop);
  companion::VehicleFile file = companion::load_vehicle(options.vehicle);
  gains::TableSet set{};
  std::string table;
  std::vector<gains::OpenStructure> structures;
  try {
    structures = structures_of(file, options);
    if (!options.tuned.empty()) {
      say_stage("the design, by margins and simulated hovers");
      const model::Vehicle present =
          options.present.empty() ? file.vehicle : companion::load_vehicle(options.present).vehicle;
      gains::tune_vehicle(file, present, structures, options.vehicle);
      file = companion::save_vehicle(options.tuned, file);
    }
    if (!options.check) {
      say_stage("the margins, with every structure and pose age");
      const model::Vehicle believed = companion::in_mode(file.vehicle, mode_of(options.mode));
      report_margins(believed, structures, options);
      gains::print_what_limits(believed, structures.front(), file, options.vehicle);
    }
    say_stage("the tables");
    gains::SetpointBox box = gains::kSetpointBox;
    std::copy(options.box.begin(), options.box.end(), box.begin());
    set = gains::make_table_set(file, box, progress_line());
    if (!options.check) {
      report_setpoint_law("x", set.x);
      report_setpoint_law("y", set.y);
    }
    if (!options.table.empty()) {
      table = table_of_modes(set, file, box);
    }
  } catch (const std::domain_error& wrong) {
    throw InputError(options.vehicle, 0, "axis", wrong.what());
  }
  std::signal(SIGINT, SIG_IGN);  // from here on the files are written
  if (!write_tables(file, set, table, options)) {
    throw companion::AnswerIsNo();
  }
}

}  // namespace

void add_gains(companion::CommandLine& lab) {
  const auto [command, options] = lab.add_subcommand<GainsOptions>(
      "gains", "make the controller's tables from a vehicle file, and report their margins", run);
  command.add_option("--vehicle", options->vehicle, "vehicle file (TOML)").required();
  command.add_option("--out", options->header, "C++ header for the firmware");
  command.add_option("--table", options->table, "gain table file for `m100 fly`");
  command.add_option("--json", options->json, "margins as JSON");
  command.add_option("--rival", options->rivals,
                     "vehicle file of another structure that the log allows; reports its margins too; may be repeated");
  command.add_option("--tune", options->tuned,
                     "make the design of the modes field and robust by the margins as flown and simulated flights, "
                     "write this vehicle file and make the tables from it");
  command.add_option("--present", options->present,
                     "vehicle file that flies now, default --vehicle: where its law keeps the limits on the new model, "
                     "the design of --tune flies no worse than it");
  companion::add_mode_option(command, options->mode, "mode whose margins are reported; the table file has all modes");
  command
      .add_option("--setpoint-box", options->box,
                  "range of the set-point law: position error [m], velocity [m/s], tilt [rad], tilt rate [rad/s], "
                  "previous input [rad], steady input [rad]; default: 6 4 0.5 2 0.75 0.31")
      .takes(6)
      .from_to(1e-6, 1e6);
  command.add_former_flag("--certify", "is gone: --corners samples the box and states its worst point");
  command.add_flag(
      "--corners", options->corners,
      "report the margins as flown over gain and frequency +-20 % of every structure, and over the whole box");
  command.add_flag("--check", options->check, "compare with the existing files instead of writing them");
}

}  // namespace m100::lab
