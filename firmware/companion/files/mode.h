// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/companion/files/vehicle_file.h"

namespace m100::companion {

/// Which tuning flies. field: the weights and noises of the vehicle file as they stand. calm_room: a loop from the same
/// file that tracks closer over the few metres of a room, with the same margins and motion of the command, and
/// overshoots more where it is sent tens of metres far. Both with their numbers: firmware/mpc/README.md and
/// host_tests/lab/experiments/README.md.
enum class Mode : std::uint8_t { kField, kCalmRoom };
inline constexpr std::array kModes{Mode::kField, Mode::kCalmRoom};

std::string_view name(Mode mode);
std::optional<Mode> mode_named(std::string_view word);

/// The vehicle with the mode's weights and observer noises.
model::Vehicle in_mode(const model::Vehicle& vehicle, Mode mode);

/// The text of the vehicle file that flies in the mode: nothing but the file's own where the mode is field. Else it
/// begins with a line that has the SHA-256 of the file it was made from, so that a gain table made from it is tied to
/// every bit of that file (promise R10), and it stands in the log as the vehicle that flew: a replay knows no modes.
std::string text_in_mode(const std::string& text, const std::string& file_name, Mode mode);

/// The same as read.
VehicleFile in_mode(const VehicleFile& file, Mode mode);

}  // namespace m100::companion
