// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "host_tests/lab/experiments/results.h"

namespace m100::lab::loop {

/// What trial flights leave of the channels that unseen data speak for.
struct Trial {
  std::set<std::string> kept;
  std::vector<std::string> said;  ///< cells that diverged, channels that were taken back, and the errors
};

/// A cell whose flight was not flown, or ended further away than any of our tasks is wide.
bool diverged(const experiments::TaskResult& cell);

/// Flies with all channels of `candidates`; where that is worse than `before`, takes back one after the other, always
/// the one without which the trial is best, until it is not worse: first by the cells that diverge in it alone, then by
/// the root mean square of the pose over the cells that diverge in neither, of which a hundredth more is no matter. A
/// cell that diverges before and after is reported and decides nothing.
/// @param before  the same cells in the same order as `fly` gives them
/// @param fly  the trial with these channels taken over; called at most n (n + 1) / 2 + 1 times for n candidates
Trial try_out(const std::set<std::string>& candidates, const std::vector<experiments::TaskResult>& before,
              const std::function<std::vector<experiments::TaskResult>(const std::set<std::string>&)>& fly);

}  // namespace m100::lab::loop
