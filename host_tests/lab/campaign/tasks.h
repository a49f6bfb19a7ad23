// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/files/flight_file.h"

namespace m100::lab::campaign {

/// One course that a campaign flies in each of its worlds.
struct Task {
  std::string_view name;
  std::string_view course;  ///< companion::parse_course
  double duration_s = 0.0;
  bool hovers = false;  ///< the task demands no tilt
};

/// hover, step_1m, step_3m, step_6m, square, trajectory: in this order.
const std::vector<Task>& all_tasks();

/// The tasks of a list "a,b,c", in the order of all_tasks(). Errors: InputError.
std::vector<Task> tasks_of(const std::string& words);

/// The flight file of a task. Fence: the course's box and 2 m around it, from 0.3 m height on. Wind class 5 m/s.
/// @param height_m height at which the course begins.
companion::FlightFile flight_file_of(const Task& task, double height_m);

}  // namespace m100::lab::campaign
