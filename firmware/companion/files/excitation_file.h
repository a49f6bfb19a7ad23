// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/files/text/file_error.h"
#include "firmware/ctl/excitation.h"

namespace m100::companion {

/// Stick movements as `m100-lab excite --out` makes them, ready to fly. Linux only; read before the first tick.
///
///   # limits roll distance 8 braking 2 speed 6 tilt 0.5     one line, beginning with '#', for each stick that moves
///   t_s,piece,stick_roll,...                                 further columns are ignored
///   0.00,1,120,...                                           piece 0: the stick rests; in flight the law returns
///
/// A piece moves one stick: roll, pitch, throttle or yaw. Limits in m, m/s^2, m/s, for yaw with rad; tilt in rad.
struct ExcitationFile {
  std::vector<std::int16_t> counts;
  std::vector<ctl::ExcitationPiece> pieces;
  std::array<ctl::ExcitationLimits, ctl::kStickAxes> limits{};

  /// The plan; it views this object.
  ctl::ExcitationPlan plan() const { return {.counts = counts, .pieces = pieces, .limits = limits}; }
  bool moves(ctl::ExcitedStick axis) const;
  double length_s() const;
};

std::string_view name(ctl::ExcitedStick axis);

/// Reads and checks a file: samples every 20 ms, sticks within their travel, one stick per piece, limits for each stick
/// that moves. Errors: FileError. @param name of the file, for messages.
ExcitationFile parse_excitation(std::string_view text, const std::string& name);

/// Converts an excitation into the text of a note in a log and back. Errors: FileError, also if that text is
/// longer than 59 000 bytes.
std::string note_of(const ExcitationFile& excitation, const std::string& name);
ExcitationFile excitation_of_note(const std::string& note);

}  // namespace m100::companion
