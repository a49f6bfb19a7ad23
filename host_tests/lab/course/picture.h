// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>

#include "firmware/companion/files/course_check.h"
#include "firmware/companion/files/flight_file.h"

namespace m100::lab::course {

/// What a course asks for at most, and where it is. Places are offsets from the start [m]; a jump of the set point is
/// asked in no time, and counts for the places alone.
struct Summary {
  double duration_s = 0.0;
  double length_m = 0.0;  ///< of the way, jumps included
  companion::Effort most;
  companion::Range x_m, y_m, z_m;
};

Summary summary_of(const ref::Trajectory<double>& course, std::span<const companion::CoursePiece> pieces,
                   const ref::Waypoint<double>& start);

/// A course as an SVG: the way seen from above, with a cross where each piece ends, and the fence, if there is one and
/// the way is not small beside it; beside it, over time, the speed, the tilt that the acceleration needs, with its
/// limit, and the height.
std::string picture(const std::string& title, const ref::Trajectory<double>& course,
                    std::span<const companion::CoursePiece> pieces, const ref::Waypoint<double>& start,
                    const companion::CourseLimits& limits, const std::optional<companion::FlightFile>& flight);

}  // namespace m100::lab::course
