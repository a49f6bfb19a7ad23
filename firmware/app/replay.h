// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "firmware/app/recorded_flight.h"
#include "firmware/core/sha256.h"

namespace m100::app {

/// Which arithmetic the flight code is run in.
enum class Scalar : std::uint8_t { kDouble, kFloat, kFixed };

struct ReplayResult {
  core::Sha256Digest digest{};  ///< over the output bytes and the state record of every tick, in order
  std::size_t ticks = 0;
  std::size_t ticks_unlike = 0;       ///< state record or output bytes not as recorded
  std::size_t first_unlike = 0;       ///< the first such tick
  double largest_difference_m = 0.0;  ///< of the estimated position, against the record
  double largest_command_difference_rad = 0.0;
};

/// What the log must have said about the flight, beside its records.
inline constexpr const char* kVehicleNote = "m100_vehicle";  ///< the vehicle file's text
inline constexpr const char* kTablesNote = "m100_tables";    ///< the gain table file's bytes
inline constexpr const char* kCourseNote = "m100_course";    ///< lay_course
inline constexpr const char* kStartNote = "m100_start";      ///< "x y z yaw" of the course's start
inline constexpr const char* kChannelNote = "m100_channel";  ///< "virtual_rc" or "movement", then "paper_100_hz" or not

/// Feeds the recorded bytes, at the recorded times, through the flight code. Errors: FlightLogError.
ReplayResult replay(const RecordedFlight& flight, Scalar scalar);

}  // namespace m100::app
