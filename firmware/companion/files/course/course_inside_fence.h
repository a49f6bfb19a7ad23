// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "firmware/companion/files/flight_file.h"

namespace m100::companion {

/// Refuses a course that leaves the fence, or a start outside it. Errors: FileError that names the axis of the
/// fence and, for a course, the line, the time and the place.
/// @param course made of `pieces`. @param course_name for messages.
void validate_inside_fence(const FlightFile& flight, const ref::Waypoint<double>& start,
                           const ref::Trajectory<double>& course, std::span<const CoursePiece> pieces,
                           const std::string& course_name);

}  // namespace m100::companion
