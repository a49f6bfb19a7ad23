// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/experiments/results.h"
#include "host_tests/lab/paired_errors.h"

namespace m100::lab::loop {

/// One task, calm and windy air together: per seed the root mean square of its cells.
struct PairedTask {
  PairedErrors pose, horizontal, vertical;
  bool is_worse() const { return horizontal.is_worse() || vertical.is_worse(); }
};
/// By task. Cells that diverged, or in which a flight never obtained control, are left out; a task with no cell left is
/// missing. Preconditions: the same cells in the same order, the same seeds.
std::map<std::string, PairedTask> compare_tasks(const std::vector<experiments::TaskResult>& before,
                                                const std::vector<experiments::TaskResult>& after);

/// Sums over cells of squared errors: of pose, horizontal and vertical, one for each seed [m^2].
using Squares = std::array<std::vector<double>, 3>;
void add(const std::vector<experiments::Cell>& flights, Squares& sums);
std::vector<double> root_mean(const std::vector<double>& sums, double cells);

/// {"flights", "before_m", "after_m", "difference_m": {"value", "low", "high"}, "verdict"} of the pose, and the same
/// under "horizontal" and "vertical". An interval that does not exist is null.
Json to_json(const PairedTask& task);

}  // namespace m100::lab::loop
