// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/paired_flights.h"

#include <algorithm>
#include <cmath>

#include "host_tests/lab/loop/trial_flights.h"

namespace m100::lab::loop {
namespace {

struct TaskSquares {
  Squares before, after;
  double cells = 0.0;
};

Json json_of(const PairedErrors& errors) {
  const auto known = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
  return {{"flights", errors.flights},
          {"before_m", errors.before_m},
          {"after_m", errors.after_m},
          {"difference_m",
           {{"value", errors.difference_m.value},
            {"low", known(errors.difference_m.low)},
            {"high", known(errors.difference_m.high)}}},
          {"verdict", errors.verdict()}};
}

}  // namespace

void add(const std::vector<experiments::Cell>& flights, Squares& sums) {
  for (std::vector<double>& sum : sums) {
    sum.resize(flights.size(), 0.0);
  }
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const experiments::Cell& cell = flights[i];
    sums[0][i] += cell.pose_m * cell.pose_m;
    sums[1][i] += cell.x_m * cell.x_m + cell.y_m * cell.y_m;
    sums[2][i] += cell.z_m * cell.z_m;
  }
}

std::vector<double> root_mean(const std::vector<double>& sums, double cells) {
  std::vector<double> out(sums.size());
  std::transform(sums.begin(), sums.end(), out.begin(), [cells](double sum) { return std::sqrt(sum / cells); });
  return out;
}

std::map<std::string, PairedTask> compare_tasks(const std::vector<experiments::TaskResult>& before,
                                                const std::vector<experiments::TaskResult>& after) {
  std::map<std::string, TaskSquares> sums;
  for (std::size_t i = 0; i < std::min(before.size(), after.size()); ++i) {
    const bool is_paired = before[i].flights.size() == after[i].flights.size() && !before[i].flights.empty();
    if (!is_paired || diverged(before[i]) || diverged(after[i])) {
      continue;
    }
    TaskSquares& task = sums[before[i].task->task];
    add(before[i].flights, task.before);
    add(after[i].flights, task.after);
    task.cells += 1.0;
  }
  std::map<std::string, PairedTask> out;
  for (const auto& [name, task] : sums) {
    const auto compare = [&task = task](std::size_t part) {
      return compare_pairs(root_mean(task.before[part], task.cells), root_mean(task.after[part], task.cells));
    };
    out[name] = {compare(0), compare(1), compare(2)};
  }
  return out;
}

Json to_json(const PairedTask& task) {
  Json out = json_of(task.pose);
  out["horizontal"] = json_of(task.horizontal);
  out["vertical"] = json_of(task.vertical);
  return out;
}

}  // namespace m100::lab::loop
