// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "firmware/companion/files/course/course.h"
#include "firmware/companion/files/course/course_validation.h"
#include "firmware/companion/files/mode.h"
#include "firmware/companion/files/text/file_error.h"
#include "firmware/core/fence.h"
#include "firmware/link/pose/pose_link.h"
#include "firmware/safety/limits.h"

namespace m100::companion {

/// From low to high.
struct Range {
  double low = 0.0;
  double high = 0.0;
  bool contains(double value) const { return value >= low && value <= high; }
};

/// Parses "field" or "robust"; the former "calm_room" as present_mode_word() says. Errors: FileError, which
/// begins with `where`.
Mode mode_of(std::string_view word, const std::string& where);

/// What a flight may do and when it ends (TOML). Linux only: reading happens once, before the first tick.
struct FlightFile {
  Mode mode = Mode::kField;
  Range fence_x_m;  ///< from where the flight starts, like fence_y_m
  Range fence_y_m;
  Range fence_z_m;            ///< height in the world of the pose
  double ground_z_m = 0.0;    ///< in the world of the pose
  double wind_m_s = 5.0;      ///< wind class for which fence and observer are designed
  double pose_fresh_s = 0.0;  ///< 0: not given; the limit follows the measured latency (safety::fresh_limit)
  double pose_coast_s = 0.0;
  double pose_level_s = 0.0;
  link::SenderChoice pose_from{};  ///< whose poses are used
  double pose_sigma_m = 0.0;       ///< link::PoseProperties::sigma_m
  link::LeverArm pose_offset_m{};
  double course_speed_m_s = 0.0;  ///< this and the next three: limits of a course; 0: those of CourseLimits
  double course_acceleration_m_s2 = 0.0;
  double course_tilt_deg = 0.0;
  double course_yaw_rate_deg_s = 0.0;
  double battery_low_percent = 20.0;  ///< at this charge or less the aircraft returns to the start; 0: never
};

/// Parses "SYS" or "SYS:COMP". Errors: FileError, which begins with `where`.
link::SenderChoice sender_of(std::string_view word, const std::string& where);

/// One key of a flight file: its place in the file, the member that it sets, its range.
struct FlightKey {
  std::string_view section;  ///< empty: the top of the file
  std::string_view key;
  std::variant<double FlightFile::*, Range FlightFile::*, Mode FlightFile::*, link::SenderChoice FlightFile::*,
               link::LeverArm FlightFile::*>
      member;
  double low = 0.0;
  double high = 0.0;
  bool required = false;
};
/// All keys of a flight file, in its order.
std::span<const FlightKey> flight_keys();

/// A range as messages show it: "[-1, 1]".
std::string text_of(const Range& range);

/// Reads and checks a flight file. The three ranges of the fence are required. Errors: FileError with file, line
/// and key, for what is unknown, missing, of a wrong type or outside its range, for a fence that cannot be flown in,
/// for a coast time that is not longer than the age limit of a pose, and for a sigma that cannot be flown inside the
/// fence.
/// @param name of the file, for messages.
FlightFile parse_flight(std::string_view text, const std::string& name);

/// Says where the origin of the pose lies; empty: at the centre of gravity.
std::string describe_lever_arm(const FlightFile& flight);

}  // namespace m100::companion
