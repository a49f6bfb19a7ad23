// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host_tests/lab/experiments/results.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::loop {

/// Non-inferiority margin: an increase is "worse" only if the 95 % interval of after / before reaches beyond 1 + this.
inline constexpr double kNonInferiority = 0.10;

/// The errors of one course, flown with the same seeds before and after.
struct PairedErrors {
  int flights = 0;  ///< number of pairs; compare_pairs() gives no interval for one
  double before_m = 0.0;
  double after_m = 0.0;
  identify::Interval difference_m;  ///< after minus before: mean of the pairs, 95 % by Student's t
  /// By the mean and the 95 % interval of the pairs' ratios after / before, taken on logarithms, so that one flight
  /// with a very large error does not hide every difference. "better": the interval lies below 1. "worse": it lies
  /// above 1 and reaches beyond the margin kNonInferiority. Otherwise "no difference".
  std::string verdict = "no difference";
  bool within_margin = false;  ///< the interval of the ratio excludes an increase beyond the margin
};
/// Mean with its 95 % interval (Student's t), which is infinite if there is only one value.
identify::Interval mean_with_interval(const std::vector<double>& values);

/// Precondition: as many errors before as after, pair by pair.
PairedErrors compare_pairs(const std::vector<double>& before_m, const std::vector<double>& after_m);

/// One task, calm and windy air together: per seed the root mean square of its cells.
struct PairedTask {
  PairedErrors pose, horizontal, vertical;
  bool is_worse() const { return horizontal.verdict == "worse" || vertical.verdict == "worse"; }
};
/// By task. Cells that diverged, or in which a flight never obtained control, are left out; a task with no cell left is
/// missing. Preconditions: the same cells in the same order, the same seeds.
std::map<std::string, PairedTask> compare_tasks(const std::vector<experiments::TaskResult>& before,
                                                const std::vector<experiments::TaskResult>& after);

/// "0.0066 -> 0.0070 m, +0.0004 [+0.0002, +0.0006], no difference (5 pairs)"
std::string describe(const PairedErrors& errors);

/// {"flights", "before_m", "after_m", "difference_m": {"value", "low", "high"}, "verdict", "within_margin"} of the
/// pose, and the same under "horizontal" and "vertical". An interval that does not exist is null.
nlohmann::json to_json(const PairedTask& task);

}  // namespace m100::lab::loop
