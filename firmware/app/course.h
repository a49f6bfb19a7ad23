// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "firmware/ref/trajectory.h"

namespace m100::app {

/// A course that cannot be read, in one line: "course:3: 'quintic': needs 5 numbers".
class CourseError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Lays a course from text, one piece a line, as flown by `m100 fly` and written into every log. Linux only; before the
/// first tick. Places are offsets from the start in m and rad, times in s; '#' begins a comment.
///
///   step X Y Z YAW SECONDS        jump there and stay
///   quintic X Y Z YAW SECONDS     rest to rest, straight
///   square SIDE PER_SIDE PAUSE    once around, from where the course is
///
/// Leaves `course` standing at the start where the text is empty. Errors: CourseError.
/// @param name of the file, for errors.
template <typename T>
void lay_course(std::string_view text, const ref::Waypoint<T>& start, ref::Trajectory<T>& course,
                const std::string& name = "course");

}  // namespace m100::app
