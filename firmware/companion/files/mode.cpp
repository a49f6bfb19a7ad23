// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/mode.h"

#include <cstdio>

#include "firmware/core/sha256.h"

namespace m100::companion {
namespace {

std::string text_of(const VehicleFile& file, Mode mode) {
  const auto digest = core::hex(file.digest);
  return "# " + std::string(name(mode)) + " of the vehicle file with SHA-256 " +
         std::string(digest.begin(), digest.end()) + "\n" + to_text(in_mode(file.vehicle, mode), file.sources);
}

/// Errors: FileError, if the file has no numbers for the mode.
const VehicleFile& checked(const VehicleFile& file, const std::string& file_name, Mode mode) {
  if (!has_mode(file, mode)) {
    throw FileError(file_name + ": 'design.robust': missing, mode robust needs it; m100-lab gains --tune makes it");
  }
  return file;
}

}  // namespace

bool has_mode(const VehicleFile& file, Mode mode) { return mode != Mode::kRobust || file.vehicle.robust.exists(); }

std::string_view name(Mode mode) { return mode == Mode::kField ? "field" : "robust"; }

std::optional<Mode> mode_named(std::string_view word) {
  for (const Mode mode : kModes) {
    if (word == name(mode)) {
      return mode;
    }
  }
  return {};
}

std::string_view present_mode_word(std::string_view word) {
  if (word != "calm_room") {
    return word;
  }
  std::puts("calm_room is gone: flown with field");
  return name(Mode::kField);
}

model::Vehicle in_mode(const model::Vehicle& vehicle, Mode mode) {
  model::Vehicle out = vehicle;
  if (mode == Mode::kRobust) {
    out.design = vehicle.robust;
    out.robust = {};
  }
  return out;
}

std::string text_in_mode(const std::string& text, const std::string& file_name, Mode mode) {
  return mode == Mode::kField ? text : text_of(checked(parse_vehicle(text, file_name), file_name, mode), mode);
}

VehicleFile in_mode(const VehicleFile& file, Mode mode) {
  const std::string word(name(mode));
  return mode == Mode::kField ? file : parse_vehicle(text_of(checked(file, "vehicle file", mode), mode), word);
}

}  // namespace m100::companion
