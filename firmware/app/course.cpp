// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/course.h"

#include <cmath>
#include <sstream>
#include <vector>

namespace m100::app {
namespace {

core::Duration seconds_of(double seconds) { return core::Duration(std::llround(seconds * 1e6)); }

[[noreturn]] void fail(const std::string& name, int line, const std::string& word, const std::string& what) {
  throw CourseError(name + ":" + std::to_string(line) + ": '" + word + "': " + what);
}

template <typename T>
ref::Waypoint<T> place(const ref::Waypoint<T>& start, const std::vector<double>& numbers) {
  ref::Waypoint<T> out = start;
  for (Eigen::Index i = 0; i < 3; ++i) {
    out.position_w_m[i] += static_cast<T>(numbers[static_cast<std::size_t>(i)]);
  }
  out.yaw_rad += static_cast<T>(numbers[3]);
  return out;
}

}  // namespace

template <typename T>
void lay_course(std::string_view text, const ref::Waypoint<T>& start, ref::Trajectory<T>& course,
                const std::string& name) {
  course.hold(start);
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string word;
    if (!(words >> word)) {
      continue;
    }
    if (word != "step" && word != "quintic" && word != "square") {
      fail(name, number, word, "no such piece");
    }
    std::vector<double> n;
    for (double value = 0.0; words >> value;) {
      n.push_back(value);
    }
    const std::size_t needed = word == "square" ? 3 : 5;
    if (!words.eof() || n.size() != needed) {
      fail(name, number, word, "needs " + std::to_string(needed) + " numbers");
    }
    core::Status status = core::Status::kOk;
    if (word == "step") {
      status = course.append_step(place(start, n), seconds_of(n[4]));
    } else if (word == "quintic") {
      status = course.append_quintic(place(start, n), seconds_of(n[4]));
    } else {
      status = course.append_square(static_cast<T>(n[0]), seconds_of(n[1]), seconds_of(n[2]));
    }
    if (status != core::Status::kOk) {
      fail(name, number, word, std::string(core::name(status)));
    }
  }
}

template void lay_course<float>(std::string_view, const ref::Waypoint<float>&, ref::Trajectory<float>&,
                                const std::string&);
template void lay_course<double>(std::string_view, const ref::Waypoint<double>&, ref::Trajectory<double>&,
                                 const std::string&);

}  // namespace m100::app
