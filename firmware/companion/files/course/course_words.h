// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/companion/files/course/course.h"

namespace m100::companion {

/// kCourseWords as text, for --help.
std::string course_help();

}  // namespace m100::companion
