// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "host_tests/lab/experiments/results.h"

namespace m100::lab::loop {

/// The channels that the trial flights keep, of those that predict unseen data better.
struct Trial {
  std::set<std::string> kept;
  std::vector<std::string> messages;  ///< cells that diverged, channels that were taken back, and the errors
};

/// Whether a flight of the cell (task and condition) never obtained control, or its mean pose RMS is above 5 m.
bool diverged(const experiments::TaskResult& cell);

/// Whether more cells diverge now than before, or as many do and the paired flights of a task are worse
/// (compare_tasks).
bool is_worse(const std::vector<experiments::TaskResult>& now, const std::vector<experiments::TaskResult>& before);

/// Flies with all channels of `candidates`. While the trial is worse than `before` (is_worse), it takes back one
/// channel, always the one without which the trial is best.
/// @param before  the same cells in the same order as `fly` gives them
/// @param fly  the trial with these channels taken over; called at most n (n + 1) / 2 times for n candidates
Trial fly_trials(const std::set<std::string>& candidates, const std::vector<experiments::TaskResult>& before,
                 const std::function<std::vector<experiments::TaskResult>(const std::set<std::string>&)>& fly);

}  // namespace m100::lab::loop
