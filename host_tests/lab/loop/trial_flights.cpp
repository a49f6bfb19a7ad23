// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/trial_flights.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "host_tests/lab/loop/paired_flights.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::loop {
namespace {

using Cells = std::vector<experiments::TaskResult>;

constexpr double kFar_m = 5.0;

/// Compares a trial with an earlier one: cells that diverge only in the new one minus those that diverge only in the
/// other, then the paired flights of each task.
struct Comparison {
  int diverged = 0;
  bool worse_in_pairs = false;
  double now_m = 0.0;
  double before_m = 0.0;
  int cells = 0;  ///< number of cells that diverge in neither
  bool is_worse() const { return diverged != 0 ? diverged > 0 : worse_in_pairs; }
  double ratio() const { return before_m > 0.0 ? now_m / before_m : 1.0; }
};

Comparison compare(const Cells& now, const Cells& before) {
  Comparison out;
  for (std::size_t i = 0; i < std::min(now.size(), before.size()); ++i) {
    const bool lost = diverged(now[i]);
    const bool was_lost = diverged(before[i]);
    out.diverged += (lost ? 1 : 0) - (was_lost ? 1 : 0);
    if (!lost && !was_lost) {
      out.now_m = std::hypot(out.now_m, now[i].mean.pose_m);
      out.before_m = std::hypot(out.before_m, before[i].mean.pose_m);
      ++out.cells;
    }
  }
  const std::map<std::string, PairedTask> pairs = compare_tasks(before, now);
  out.worse_in_pairs = std::any_of(pairs.begin(), pairs.end(), [](const auto& task) { return task.second.is_worse(); });
  return out;
}

std::string lost_cells(const Cells& cells) {
  std::string out;
  for (const experiments::TaskResult& cell : cells) {
    if (diverged(cell)) {
      out += (out.empty() ? "" : ", ") + cell.task->task + " " + cell.task->condition +
             (cell.refused > 0 ? " (control was not obtained)" : "");
    }
  }
  return out;
}

std::string describe(const Comparison& comparison) {
  return comparison.cells == 0
             ? "no task was flown to its end both before and after"
             : printed("pose RMS %.4f m before, %.4f m after, at equal margin", comparison.before_m, comparison.now_m);
}

void report_lost(const Cells& before, const Cells& now, Trial& out) {
  if (const std::string lost = lost_cells(before); !lost.empty()) {
    out.messages.push_back("trial flights: diverged with the present vehicle file: " + lost);
  }
  if (const std::string lost = lost_cells(now); !lost.empty()) {
    out.messages.push_back("trial flights: diverged with the found models: " + lost);
  }
}

/// The channel of `kept` without which the trial is best, and the cells flown without it.
std::pair<std::string, Cells> without_one(const std::set<std::string>& kept, const Cells& before,
                                          const std::function<Cells(const std::set<std::string>&)>& fly) {
  std::optional<std::string> culprit;
  Cells best;
  for (const std::string& channel : kept) {
    std::set<std::string> fewer = kept;
    fewer.erase(channel);
    Cells flown = fewer.empty() ? before : fly(fewer);
    const Comparison against = culprit ? compare(flown, best) : Comparison{};
    if (!culprit || against.diverged < 0 || (against.diverged == 0 && against.ratio() < 1.0)) {
      culprit = channel;
      best = std::move(flown);
    }
  }
  return {*culprit, std::move(best)};
}

}  // namespace

bool diverged(const experiments::TaskResult& cell) {
  return cell.refused > 0 || !std::isfinite(cell.mean.pose_m) || cell.mean.pose_m > kFar_m;
}

bool is_worse(const Cells& now, const Cells& before) { return compare(now, before).is_worse(); }

Trial fly_trials(const std::set<std::string>& candidates, const Cells& before,
                 const std::function<Cells(const std::set<std::string>&)>& fly) {
  Trial out{.kept = candidates, .messages = {}};
  if (candidates.empty()) {
    return out;
  }
  Cells now = fly(out.kept);
  report_lost(before, now, out);
  while (is_worse(now, before)) {
    auto [culprit, best] = without_one(out.kept, before, fly);
    out.messages.push_back(culprit +
                           ": taken back, trial flights are worse with it: " + describe(compare(now, before)));
    out.kept.erase(culprit);
    now = std::move(best);
    if (out.kept.empty()) {
      return out;
    }
  }
  out.messages.push_back("trial flights: " + describe(compare(now, before)));
  return out;
}

}  // namespace m100::lab::loop
