// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/mode.h"

#include "firmware/core/sha256.h"

namespace m100::companion {
namespace {

/// Factors instead of absolute weights, so that a vehicle with cautious weights stays cautious in a calm room, too.
/// With them, steps of 1 to 6 m are 4 % closer to the time-optimal ones, with the same margins and command motion.
/// Jumps of tens of metres, for which a room has no space, overshoot more (firmware/mpc/README.md).
constexpr double kCalmVelocityWeight = 0.5;
constexpr double kCalmInputWeight = 7.0 / 12.0;

std::string text_of(const VehicleFile& file, Mode mode) {
  const auto digest = core::hex(file.digest);
  return "# " + std::string(name(mode)) + " of the vehicle file with SHA-256 " +
         std::string(digest.begin(), digest.end()) + "\n" + to_text(in_mode(file.vehicle, mode), file.sources);
}

/// Errors: VehicleFileError, if the file has no numbers for the mode.
const VehicleFile& checked(const VehicleFile& file, const std::string& file_name, Mode mode) {
  if (!has_mode(file, mode)) {
    throw VehicleFileError(file_name +
                           ": 'design.robust': missing, mode robust needs it; m100-lab gains --tune makes it");
  }
  return file;
}

}  // namespace

bool has_mode(const VehicleFile& file, Mode mode) { return mode != Mode::kRobust || file.vehicle.robust.exists(); }

std::string_view name(Mode mode) {
  return mode == Mode::kField ? "field" : mode == Mode::kCalmRoom ? "calm_room" : "robust";
}

std::optional<Mode> mode_named(std::string_view word) {
  for (const Mode mode : kModes) {
    if (word == name(mode)) {
      return mode;
    }
  }
  return {};
}

model::Vehicle in_mode(const model::Vehicle& vehicle, Mode mode) {
  model::Vehicle out = vehicle;
  if (mode == Mode::kRobust) {
    out.design = vehicle.robust;
    out.robust = {};
  }
  if (mode == Mode::kCalmRoom) {
    out.design = out.robust = {};
    out.mpc.velocity *= kCalmVelocityWeight;
    out.mpc.input *= kCalmInputWeight;
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
