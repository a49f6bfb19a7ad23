// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/experiments/tasks.h"

#include <array>
#include <sstream>

namespace m100::lab::experiments {
namespace {

namespace paper = model::paper;
/// A course that waits for first_s and then steps from goal to goal every every_s. Goals are offsets from the start.
struct Goals {
  double first_s = 0.0;
  double every_s = 0.0;
  std::vector<std::array<double, 3>> offsets_m;

  std::string course() const {
    std::ostringstream out;
    out << "step 0 0 0 0 " << first_s << "\n";
    for (const std::array<double, 3>& goal : offsets_m) {
      out << "step " << goal[0] << " " << goal[1] << " " << goal[2] << " 0 " << every_s << "\n";
    }
    return out.str();
  }
  /// Horizontal distances, separately for each axis, because each axis has its own tilt.
  std::vector<double> distances_m() const {
    std::vector<double> out;
    std::array<double, 3> before{};
    for (const std::array<double, 3>& goal : offsets_m) {
      out.push_back(goal[0] - before[0]);
      out.push_back(goal[1] - before[1]);
      before = goal;
    }
    return out;
  }
};

/// Six metres in x, eight in y, changes of height by 0.2 m.
const Goals kCalmSteps{
    22.0, 11.0, {{1, 1, 0.2}, {0, 2, 0.2}, {-1, 1, 0}, {0, 0, 0}, {1, -1, 0.2}, {0, -2, 0}, {0, -1, 0}, {0, 0, 0}}};
/// Two metres in x, six in y.
const Goals kWindySteps{22.0, 15.0, {{1, 1, 0.2}, {1, 2, 0.2}, {0, 1, 0}, {0, 0, 0.2}, {0, -1, 0}, {0, 0, 0}}};
const Goals kSixMetres{22.0, 90.0, {{6, 0, 0}}};
const Goals kTwoMetres{22.0, 90.0, {{2, 0, 0}}};

/// The square repeated, with half a second of rest in every corner.
std::string squares() {
  std::string out = "step 0 0 0 0 15\n";
  for (int round = 0; round < 6; ++round) {
    out += "square 1 2.5 0.5\n";
  }
  return out;
}

/// Four goal positions and headings, twice, with rests between them.
std::string simulator_course() {
  std::string out = "step 0 0 0 0 3\n";
  for (int round = 0; round < 2; ++round) {
    for (const char* const goal : {"2 0 0.5 1.5707963", "2 2 1.0 3.1415926", "0 2 0.5 1.5707963", "0 0 0 0"}) {
      out += std::string("quintic ") + goal + " 6\n";
      out += std::string("step ") + goal + " 5.5\n";
    }
  }
  return out;
}

}  // namespace

const std::vector<Task>& paper_tasks() {
  static const std::vector<Task> tasks{
      {"hover", "calm", "", 15, 75, false, true, &paper::kHoverCalm, {}},
      {"hover", "wind", "", 15, 75, true, true, &paper::kHoverWind, {}},
      {"step", "calm", kCalmSteps.course(), 20, 120, false, false, &paper::kStepCalm, kCalmSteps.distances_m()},
      {"step", "wind", kWindySteps.course(), 20, 120, true, false, &paper::kStepWind, kWindySteps.distances_m()},
      {"trajectory", "calm", squares(), 30, 80, false, false, &paper::kTrajectoryCalm, {}},
      {"trajectory", "wind", squares(), 20, 70, true, false, &paper::kTrajectoryWind, {}},
      {"simulator", "calm", simulator_course(), 5, 100, false, false, &paper::kTrajectorySimulator, {}}};
  return tasks;
}

const std::vector<Task>& literal_steps() {
  static const std::vector<Task> tasks{
      {"step_6m", "calm", kSixMetres.course(), 20, 120, false, false, nullptr, kSixMetres.distances_m()},
      {"step_2m", "wind", kTwoMetres.course(), 20, 120, true, false, nullptr, kTwoMetres.distances_m()}};
  return tasks;
}

}  // namespace m100::lab::experiments
