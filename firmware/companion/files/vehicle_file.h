// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>

#include "firmware/core/sha256.h"
#include "firmware/model/vehicle.h"

namespace m100::companion {

/// An error in a vehicle file, in one line: "v.toml:12: 'axis.roll.damping_ratio': must be in [0.05, 5]".
class VehicleFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A vehicle file (TOML) as read or as it will be written. Linux only: reading happens once, before the first tick.
struct VehicleFile {
  model::Vehicle vehicle;
  std::map<std::string, std::string> sources;  ///< section ("axis.roll") -> its `source` text
  std::set<std::string> sections;              ///< sections that the file had
  core::Sha256Digest digest{};                 ///< of the bytes of the file; ties gain tables to it
};

/// Reads and checks a vehicle file. Sections may be missing (their numbers keep the defaults of model::Vehicle);
/// unknown sections or keys, wrong types and values outside their range are errors, and so is an axis with both a time
/// constant and a natural frequency, or with neither. Errors: VehicleFileError.
VehicleFile load_vehicle(const std::string& path);
/// The same from text; `name` is the file's name in messages.
VehicleFile parse_vehicle(std::string_view text, const std::string& name);

/// The file's text: all sections, keys in a fixed order, numbers in the shortest form that reads back to the same bits.
std::string to_text(const model::Vehicle& vehicle, const std::map<std::string, std::string>& sources);

/// Writes the text and returns what load_vehicle would read. Errors: VehicleFileError.
VehicleFile save_vehicle(const std::string& path, const model::Vehicle& vehicle,
                         const std::map<std::string, std::string>& sources);

/// An in-memory vehicle with the digest that its file would have.
VehicleFile as_file(const model::Vehicle& vehicle, const std::map<std::string, std::string>& sources = {});

}  // namespace m100::companion
