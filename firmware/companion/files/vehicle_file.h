// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/files/text/file_error.h"
#include "firmware/core/sha256.h"
#include "firmware/model/vehicle.h"

namespace m100::companion {

/// A 95 % interval of an identified number.
struct Interval {
  double low = 0.0;
  double high = 0.0;
};
using Intervals = std::map<std::string, Interval>;  ///< by the key of the number

/// A structure of one axis that the log cannot distinguish from [axis.*]: a [[rival]] of the vehicle file.
struct Rival {
  std::string axis;  ///< "roll" or "pitch"
  model::StickAxis numbers;
  Intervals intervals;
  double probability = 0.0;  ///< 0: not stated
  std::string source;
};

/// A vehicle file (TOML) as read or as it will be written. Linux only: reading happens once, before the first tick.
struct VehicleFile {
  model::Vehicle vehicle;
  std::map<std::string, std::string> sources;  ///< section ("axis.roll") -> its `source` text
  std::set<std::string> sections;              ///< sections that the file had
  std::map<std::string, Intervals> intervals;  ///< section ("axis.roll") -> its KEY_low and KEY_high
  std::vector<Rival> rivals;                   ///< in the order of the file
  core::Sha256Digest digest{};                 ///< of the bytes of the file; ties gain tables to it
};

/// Reads and checks a vehicle file. Sections may be missing: their numbers keep the defaults of model::Vehicle. A
/// number of an axis may have both KEY_low and KEY_high beside it. Errors: FileError, for unknown sections or
/// keys, wrong types, values outside their range, and an axis without its scale or without exactly one of a time
/// constant and a natural frequency.
VehicleFile load_vehicle(const std::string& path);
/// As load_vehicle(), from text; `name` is the file's name in messages.
VehicleFile parse_vehicle(std::string_view text, const std::string& name);

/// The file's text: the vehicle's sections, keys in a fixed order, numbers in the shortest form that keeps all bits.
std::string to_text(const model::Vehicle& vehicle, const std::map<std::string, std::string>& sources);

/// The file's text with its intervals and rivals.
std::string to_text(const VehicleFile& file);

/// Writes the text and returns what load_vehicle would read. Errors: FileError.
VehicleFile save_vehicle(const std::string& path, const VehicleFile& file);
VehicleFile save_vehicle(const std::string& path, const model::Vehicle& vehicle,
                         const std::map<std::string, std::string>& sources);

/// An in-memory vehicle with the digest that its file would have.
VehicleFile as_file(const model::Vehicle& vehicle, const std::map<std::string, std::string>& sources = {});

}  // namespace m100::companion
