// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/experiments/score.h"
#include "host_tests/lab/experiments/tasks.h"

namespace m100::lab::experiments {

/// One task flown with several seeds.
struct TaskResult {
  const Task* task = nullptr;
  Cell mean;
  Cell spread;                      ///< standard deviation over the seeds
  std::vector<Cell> flights;        ///< of the seeds that obtained control, in their order
  double time_optimal_m = 0.0;      ///< horizontal RMS of the fastest possible flight; 0: no steps, or not flown
  double time_optimal_share = 0.0;  ///< time_optimal_m divided by our horizontal RMS; 1 would be perfect
  int seeds = 0;
  bool flown() const { return seeds > refused; }  ///< false: mean, spread and trace are invalid
  int refused = 0;                                ///< flights that never obtained control; excluded from the means
  int baselines_refused = 0;                      ///< the same, of the flights with the baselines' laws
  double largest_tilt_deg = 0.0;
  double touchdown_speed_m_s = 0.0;
  double seconds_per_flight = 0.0;  ///< of computer time
  double simulated_s = 0.0;         ///< of all flights, those with other laws too
  Trace trace;                      ///< of the first seed, every fifth tick
  std::optional<Cell> baseline;     ///< mean of the task's flights with the clipped LQR
  std::optional<Cell> paper_law;    ///< mean of the task's flights with the law of the paper's authors
};

struct SuiteOptions {
  /// What all flights have in common; the tasks give the rest. With a body no fan blows, and the plant's wind only in
  /// the tasks in wind.
  FlightPlan plan;
  std::string only;  ///< a task's name; empty: all
  std::uint64_t seed = 1;
  int seeds = 1;
  bool paper_law = false;  ///< flies in_paper_configuration()
  bool baseline = false;   ///< flies each task with the clipped LQR and with the law of the paper's authors, too
  bool literal_steps = true;
  std::function<void(const std::string&)> progress;  ///< called with one line per task; may be empty
  /// Called with the ULog bytes of each task's flight of the first seed; empty: no log is kept.
  std::function<void(const Task&, std::string)> keep_log;
};

/// Flies the selected tasks. Without a body, the same options give the same errors, bit for bit.
std::vector<TaskResult> fly_suite(const SuiteOptions& options);

/// A cell that is compared with the paper's, by its name in JSON, and whether ours is above it or was never flown.
struct PaperComparison {
  std::string name;
  bool above = false;
};
std::vector<PaperComparison> compared(const TaskResult& result);
/// The number of our cells that are above the paper's; a cell never flown counts as above.
int cells_above_paper(const std::vector<TaskResult>& results);
/// The cells that cells_above_paper() counts: " (hover, calm: x_m; ...)"; empty: there are none.
std::string above_words(const std::vector<TaskResult>& results);

/// Prints the paper's results table side by side with ours.
void print_table(std::ostream& out, const std::vector<TaskResult>& results);
/// {"hover": {"calm": {...}, "wind": {...}}, ..., "cells_above_paper": 3}. The errors of a task never flown are null.
Json to_json(const std::vector<TaskResult>& results);

}  // namespace m100::lab::experiments
