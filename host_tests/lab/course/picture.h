// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>

#include "firmware/companion/files/course/course_validation.h"
#include "firmware/companion/files/flight_file.h"

namespace m100::lab::course {

/// The largest demands of a course, and its extent. Positions are offsets from the start [m]; a step of the set point
/// takes no time and counts only for length and extent.
struct Summary {
  double duration_s = 0.0;
  double length_m = 0.0;  ///< length of the path, including steps
  companion::MotionMagnitudes most;
  companion::Range x_m, y_m, z_m;
};

Summary summary_of(const ref::Trajectory<double>& course, std::span<const companion::CoursePiece> pieces,
                   const ref::Waypoint<double>& start);

/// A course as an SVG. Left: the path from above, with a cross at the start and at the end of each piece, and the fence
/// if the path leaves it or is larger than a third of it. Right, over time: the speed, the tilt that the acceleration
/// requires with its limit, and the height.
std::string picture(const std::string& title, const ref::Trajectory<double>& course,
                    std::span<const companion::CoursePiece> pieces, const ref::Waypoint<double>& start,
                    const companion::CourseLimits& limits, const std::optional<companion::FlightFile>& flight);

}  // namespace m100::lab::course
