// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/campaign/tasks.h"

#include <algorithm>
#include <memory>

#include "firmware/companion/files/text/suggestion.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/option_words.h"

namespace m100::lab::campaign {
namespace {

constexpr double kMargin_m = 2.0;
constexpr double kFloor_m = 0.3;
constexpr double kWindClass_m_s = 5.0;

constexpr std::string_view kThere1m = "step 0 0 0 0 8\nstep 1 0 0 0 11\nstep 0 0 0 0 11\n";
constexpr std::string_view kThere3m = "step 0 0 0 0 8\nstep 3 0 0 0 11\nstep 0 0 0 0 11\n";
constexpr std::string_view kThere6m = "step 0 0 0 0 8\nstep 6 0 0 0 11\nstep 0 0 0 0 11\n";
constexpr std::string_view kSquares = "step 0 0 0 0 6\nsquare 1 2.5 0.5\nsquare 1 2.5 0.5\n";
constexpr std::string_view kGoals =
    "step 0 0 0 0 4\n"
    "quintic 2 0 0.5 1.5707963 6\nstep 2 0 0.5 1.5707963 1\n"
    "quintic 2 2 1 3.1415926 6\nstep 2 2 1 3.1415926 1\n"
    "quintic 0 2 0.5 1.5707963 6\nstep 0 2 0.5 1.5707963 1\n"
    "quintic 0 0 0 0 6\nstep 0 0 0 0 1\n";

}  // namespace

const std::vector<Task>& all_tasks() {
  static const std::vector<Task> kTasks{{"hover", "", 30.0, true},   {"step_1m", kThere1m, 30.0},
                                        {"step_3m", kThere3m, 30.0}, {"step_6m", kThere6m, 30.0},
                                        {"square", kSquares, 30.0},  {"trajectory", kGoals, 32.0}};
  return kTasks;
}

std::vector<Task> tasks_of(const std::string& words) {
  const std::vector<std::string> wanted = list_of("--tasks", words);
  for (const std::string& word : wanted) {
    if (std::none_of(all_tasks().begin(), all_tasks().end(), [&](const Task& task) { return task.name == word; })) {
      throw InputError("--tasks", 0, word,
                       "is not a task; the tasks are hover, step_1m, step_3m, step_6m, square, trajectory" +
                           companion::did_you_mean(word, all_tasks(), &Task::name));
    }
  }
  std::vector<Task> tasks;
  for (const Task& task : all_tasks()) {
    if (std::find(wanted.begin(), wanted.end(), task.name) != wanted.end()) {
      tasks.push_back(task);
    }
  }
  if (tasks.empty()) {
    throw InputError("--tasks", 0, "", "names no task");
  }
  return tasks;
}

companion::FlightFile flight_file_of(const Task& task, double height_m) {
  companion::FlightFile file;
  file.wind_m_s = kWindClass_m_s;
  ref::Waypoint<double> start;
  start.position_w_m.z() = height_m;
  const auto course = std::make_unique<ref::Trajectory<double>>();
  companion::parse_course(std::string(task.course), start, *course);
  course->start(core::TimePoint{});
  companion::Range z{height_m, height_m};
  const auto widen = [](companion::Range& range, double value) {
    range.low = std::min(range.low, value);
    range.high = std::max(range.high, value);
  };
  for (double t_s = 0.0; t_s <= task.duration_s; t_s += 0.05) {
    const core::TimePoint at(core::Duration(static_cast<core::Duration::rep>(t_s * 1e6)));
    const ref::Window<double> window = course->window(at, core::Duration{0});
    widen(file.fence_x_m, window.x[0].position_m);
    widen(file.fence_y_m, window.y[0].position_m);
    widen(z, window.height.position_m);
  }
  file.fence_x_m = {file.fence_x_m.low - kMargin_m, file.fence_x_m.high + kMargin_m};
  file.fence_y_m = {file.fence_y_m.low - kMargin_m, file.fence_y_m.high + kMargin_m};
  file.fence_z_m = {kFloor_m, z.high + kMargin_m};
  return file;
}

}  // namespace m100::lab::campaign
