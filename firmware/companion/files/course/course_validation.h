// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <limits>
#include <span>
#include <string>

#include "firmware/companion/files/course/course.h"
#include "firmware/safety/limits.h"

namespace m100::companion {

/// The limits of any course. A flight file may set lower ones. Climb and yaw rate: what the supervisor passes. Tilt:
/// the law's input limit along an axis; the margin from there to the supervisor's limit is for braking in wind.
struct CourseLimits {
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  double speed_m_s = kNone;
  double acceleration_m_s2 = kNone;
  double tilt_rad = ref::SpeedLimits{}.tilt_rad;
  double climb_m_s = safety::Envelope{}.climb_m_s;
  double yaw_rate_rad_s = safety::Envelope{}.yaw_rate_rad_s;
};

/// The limited quantities at one time.
struct MotionMagnitudes {
  double speed_m_s = 0.0;
  double acceleration_m_s2 = 0.0;
  double tilt_rad = 0.0;  ///< ref::tilt_of the acceleration
  double climb_m_s = 0.0;
  double yaw_rate_rad_s = 0.0;
};
MotionMagnitudes magnitudes_of(const ref::Motion& motion);

/// Calls `look` for times of a course at most 10 ms apart (in pieces longer than 40 s: 4000 per piece), including both
/// ends of each piece.
void for_each_sample(const ref::Trajectory<double>& course, std::span<const CoursePiece> pieces,
                     const std::function<void(const CoursePiece&, core::Duration at, const ref::Motion&)>& look);

/// "1.25 s after the beginning, at (1.20, 0.40, 1.00) m from the start"
std::string when_and_where(core::Duration at, const ref::Motion& motion, const ref::Waypoint<double>& start);

/// Refuses a course
///  - that exceeds its own 'limits', the given ones or the supervisor's by more than 1 % (a way of minimum snap keeps
///    its limits within 1 %);
///  - whose pieces do not join in place, velocity and acceleration (1 mm, 1 cm/s, 5 cm/s^2; as many rad for the
///    heading); a set point may jump, but only from rest, and not so far that it would exceed limits.speed_m_s;
///  - that ends in motion.
/// Errors: CourseError with file, line and word, and unless a jump is too far, with time and place.
void validate_course(const ref::Trajectory<double>& course, std::span<const CoursePiece> pieces,
                     const ref::Waypoint<double>& start, const CourseLimits& limits, const std::string& course_name);

}  // namespace m100::companion
