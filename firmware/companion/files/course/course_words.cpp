// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/course/course_words.h"

namespace m100::companion {

std::string course_help() {
  std::string help =
      "A course file has one piece per line; places are offsets from the start [m, rad], along the axes of the "
      "world:\n";
  for (const CourseWord& word : kCourseWords) {
    help += "  " + std::string(word.word) + (word.arguments.empty() ? "" : " ") + std::string(word.arguments) +
            "\n      " + std::string(word.sentence) + "\n";
  }
  return help;
}

}  // namespace m100::companion
