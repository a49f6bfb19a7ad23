// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/ref/trajectory.h"

namespace m100::companion {

/// A course that cannot be read, in one line: "course:3: 'quintic': needs 5 numbers".
class CourseError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A word that begins a line of a course. `--help`, the reference page and the parser's suggestions read this table.
struct CourseWord {
  std::string_view word;
  std::string_view arguments;
  std::string_view sentence;
};
inline constexpr std::array kCourseWords{
    CourseWord{"step", "X Y Z YAW SECONDS", "jump there and stay; below 'limits', go there within them and stay"},
    CourseWord{"quintic", "X Y Z YAW SECONDS", "fly straight from rest to rest in this time"},
    CourseWord{"square", "SIDE PER_SIDE PAUSE", "fly once around, at rest in every corner; times in s"},
    CourseWord{"limits", "[speed_m_s V] [acceleration_m_s2 A] [tilt_deg D] [yaw_rate_deg_s R]",
               "limits of the lines below; 'through' and 'step' are flown as fast as they allow"},
    CourseWord{"through", "X Y Z YAW",
               "fly through here; consecutive lines are one way of minimum snap, at rest at both ends only"},
    CourseWord{"circle", "RADIUS SPEED TURNS",
               "begins along +x with its centre to the left, or, with a negative radius, to the right"},
    CourseWord{"eight", "LENGTH WIDTH SPEED TURNS",
               "a figure of eight, long in x, that begins where it crosses itself; SPEED is the highest"},
    CourseWord{"polynomial", "SECONDS x|y|z|yaw C0 C1 ... [x|y|z|yaw C0 ...]",
               "C0 + C1 t + C2 t^2 ..., up to t^7, t in s from its beginning; it must join the course there"},
    CourseWord{"t_s,x_m,y_m,z_m[,yaw_rad|,yaw_deg]", "",
               "the head of a table: one place and its time per line, flown through with minimum snap; ends at the "
               "next word"}};

/// kCourseWords as text, for --help.
std::string course_help();

inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();
inline constexpr ref::SpeedLimits kNoLimits{
    .speed_m_s = kNoLimit, .acceleration_m_s2 = kNoLimit, .yaw_rate_rad_s = kNoLimit, .tilt_rad = kNoLimit};

/// One line of a course, with its times.
struct CoursePiece {
  int line = 0;
  std::string word;
  core::Duration begin{0};  ///< time since the start of the course
  core::Duration end{0};
  ref::SpeedLimits limits = kNoLimits;  ///< of the 'limits' lines above; infinite if not named
};

/// Makes a course from text, line by line. Linux only; before the first tick. The words: kCourseWords. Places are
/// offsets from the start in m and rad along the axes of the world; '#' begins a comment. A file that holds only a
/// table of time and place is a course, too.
///
/// With an empty text, `course` holds the start. Errors: CourseError.
/// @param name of the file, for errors. @returns the pieces, in order: one for each line that moves or holds.
template <typename T>
std::vector<CoursePiece> parse_course(std::string_view text, const ref::Waypoint<T>& start, ref::Trajectory<T>& course,
                                      const std::string& name = "course");

}  // namespace m100::companion
