// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/companion/files/vehicle_file.h"

namespace m100::companion {

/// The tuning that flies. field: the vehicle file with its [design]. robust: the vehicle file with its [design.robust],
/// for an aircraft that is known badly. Figures of both: firmware/mpc/README.md.
enum class Mode : std::uint8_t { kField, kRobust };
inline constexpr std::array kModes{Mode::kField, Mode::kRobust};  ///< order of the tables in a file
/// The words that --mode and a flight file take.
inline constexpr std::array kModeNames{"field", "robust"};

/// Whether the file has the numbers of the mode: only robust needs a section of its own.
bool has_mode(const VehicleFile& file, Mode mode);
std::string_view name(Mode mode);
std::optional<Mode> mode_named(std::string_view word);
/// The word itself. For the former mode calm_room "field", and one line on standard output says so: its loop was
/// unstable where gain and frequency were 20 % off, and it held the hover only 0.4 mm better.
std::string_view present_mode_word(std::string_view word);

/// The vehicle with the mode's design: robust, the axes, weights and noises of [design.robust].
model::Vehicle in_mode(const model::Vehicle& vehicle, Mode mode);

/// The text of the vehicle file that flies in the mode. In mode field it is the file's own text. Otherwise it begins
/// with a line that has the SHA-256 of the original file, so that a gain table made from it is tied to every bit of
/// that file (promise R10).
std::string text_in_mode(const std::string& text, const std::string& file_name, Mode mode);

/// The vehicle file of text_in_mode(), parsed. Errors of both: FileError, if has_mode() is false.
VehicleFile in_mode(const VehicleFile& file, Mode mode);

}  // namespace m100::companion
