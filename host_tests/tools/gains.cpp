// SPDX-License-Identifier: BSD-3-Clause
// m100-lab gains: gain tables of a vehicle file, and what they promise.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>

#include "firmware/app/vehicle_file.h"
#include "host_tests/tools/gains/gain_tables.h"
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
  bool check = false;
};

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
  const app::VehicleFile file = app::load_vehicle(options.vehicle);
  gains::TableSet set{};
  try {
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
  command->add_flag("--check", options->check, "compare with the files that are there instead of writing them");
  command->callback([options] { run(*options); });
}

}  // namespace m100::tools
