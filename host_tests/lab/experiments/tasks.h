// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "firmware/model/paper.h"
#include "host_tests/lab/experiments/flight.h"

namespace m100::lab::experiments {

/// One column of the paper's results table, and the task that we fly for it.
struct Task {
  std::string task;       ///< "hover", "step", "trajectory", "simulator"; "step_6m", "step_2m"
  std::string condition;  ///< "calm" or "wind"
  std::string course;     ///< companion::parse_course
  double from_s = 0.0;    ///< window of the root mean squares (the paper's durations)
  double to_s = 0.0;
  bool fan = false;
  bool tilt_counts = false;                           ///< roll and pitch are compared: in the hovers only
  const model::paper::ResultColumn* paper = nullptr;  ///< null: not in the paper
  std::vector<double> steps_m;  ///< distances of the set points, for the time-optimal bound; empty: no steps
};

/// The seven columns of the table.
///
/// The paper names few sizes. Steps: its "2 m along x in windy condition, whereas it moves 6 m" (IV-D.3) are taken as
/// total distances, flown with goals 1 m apart, because even the fastest single step of 6 m has a larger RMS than the
/// paper reports. In y, 6 m are flown in wind, 8 m in calm air. literal_steps: the literal single steps.
/// Trajectory: the 1 x 1 m square (IV-D.4), minimum-jerk sides of 2.5 s. Simulator: four goals with heading (IV-D.1).
const std::vector<Task>& paper_tasks();
/// One step of 6 m in x, calm; one of 2 m, windy.
const std::vector<Task>& literal_steps();

}  // namespace m100::lab::experiments
