// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/ground_station/set_point_stream.h"

// What a flight file says, in the types of the rooms that use it.
namespace m100::companion {

/// The fence in the world of the pose. The flight's ranges of x and y count from `start`.
core::Fence fence_of(const FlightFile& flight, const ref::Waypoint<double>& start);

/// The failsafe's limits: the times of the file, otherwise the defaults.
safety::Limits limits_of(const FlightFile& flight);

/// The limits of a course.
CourseLimits course_limits_of(const FlightFile& flight);
/// The speed limits on the way to a goal: the smaller of the defaults for goals and the limits of a course. An
/// acceleration a in any direction, including down, needs a tilt of at most asin(a / g).
ref::SpeedLimits goal_limits_of(const FlightFile& flight);
/// The limits of a stream of set points: those of a course; without a speed in the file, that of goals.
StreamLimits stream_limits_of(const FlightFile& flight);

/// Refuses a course that leaves the fence, or a start outside it. Errors: FileError that names the axis of the
/// fence and, for a course, the line, the time and the place.
/// @param course made of `pieces`. @param course_name for messages.
void validate_inside_fence(const FlightFile& flight, const ref::Waypoint<double>& start,
                           const ref::Trajectory<double>& course, std::span<const CoursePiece> pieces,
                           const std::string& course_name);

}  // namespace m100::companion
