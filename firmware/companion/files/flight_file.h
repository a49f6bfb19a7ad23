// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "firmware/companion/files/course.h"
#include "firmware/companion/files/course_check.h"
#include "firmware/companion/files/mode.h"
#include "firmware/core/fence.h"
#include "firmware/safety/limits.h"

namespace m100::companion {

/// What is wrong with a flight file, or with a course in its box, in one line: "f.toml:3: 'fence.x_m': is missing".
class FlightFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// From low to high.
struct Range {
  double low = 0.0;
  double high = 0.0;
  bool contains(double value) const { return value >= low && value <= high; }
};

/// "field" or "calm_room". Errors: FlightFileError, which says `where` the word stands.
Mode mode_of(std::string_view word, const std::string& where);

/// What a flight may do and when it ends (TOML). Linux only: reading happens once, before the first tick.
struct FlightFile {
  Mode mode = Mode::kField;
  Range fence_x_m;  ///< from where the flight starts
  Range fence_y_m;
  Range fence_z_m;            ///< of the height in the world of the pose
  double ground_z_m = 0.0;    ///< in the world of the pose
  double wind_m_s = 5.0;      ///< the class that the fence and the observer reckon with
  double pose_fresh_s = 0.0;  ///< 0: not said, as the measured latency needs (safety::fresh_limit)
  double pose_coast_s = 0.0;
  double pose_level_s = 0.0;
  double course_speed_m_s = 0.0;  ///< what a course may ask for; 0: not said, as CourseLimits has it
  double course_acceleration_m_s2 = 0.0;
  double course_tilt_deg = 0.0;
  double course_yaw_rate_deg_s = 0.0;
  double battery_low_percent = 20.0;  ///< from this charge on the flight ends where it began; 0: it does not matter
};

/// One key of a flight file: where it stands, what it fills, what it may be. Exactly one of the three places is set.
struct FlightKey {
  std::string_view section;  ///< empty: the top of the file
  std::string_view key;
  double FlightFile::*number = nullptr;
  Range FlightFile::*range = nullptr;
  Mode FlightFile::*mode = nullptr;
  double low = 0.0;
  double high = 0.0;
  bool required = false;
};
/// All of them, in the order of the file.
std::span<const FlightKey> flight_keys();

/// Reads and checks a flight file. The three ranges of the fence must be there; unknown sections or keys, wrong types,
/// values outside their range, a fence without the start in it and a coast that is over before a pose is old are
/// errors. Errors: FlightFileError with file, line and key.
/// @param name stands for the file in messages.
FlightFile parse_flight(std::string_view text, const std::string& name);

/// The box in the world of the pose, from where the flight starts.
core::Fence fence_of(const FlightFile& flight, const ref::Waypoint<double>& start);

/// The ladder's times as the file has them.
safety::Limits limits_of(const FlightFile& flight);

/// What a course may ask for.
CourseLimits course_limits_of(const FlightFile& flight);
/// What the ways to goals may ask for: the less of what goals do by themselves and what a course may. An acceleration
/// a in any direction, down as well, is flown by a tilt of asin(a / g) at most.
ref::SpeedLimits goal_limits_of(const FlightFile& flight);

/// Refuses a course that leaves the box, or a start outside of it. Errors: FlightFileError that names the line of the
/// course, the side of the box, the time and the place.
/// @param course as laid, by `pieces`. @param course_name for messages.
void expect_inside(const FlightFile& flight, const ref::Waypoint<double>& start, const ref::Trajectory<double>& course,
                   std::span<const CoursePiece> pieces, const std::string& course_name);

}  // namespace m100::companion
