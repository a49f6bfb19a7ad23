// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/paired_flights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "host_tests/lab/loop/trial_flights.h"
#include "host_tests/lab/statistics.h"
#include "host_tests/lab/student_t.h"

namespace m100::lab::loop {
namespace {

constexpr double kMin_m = 1e-6;  ///< errors below a micrometre count as one: their ratio says nothing

using Squares = std::array<std::vector<double>, 3>;  ///< of pose, horizontal and vertical error, one for each seed

struct TaskSquares {
  Squares before, after;
  double cells = 0.0;
};

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

nlohmann::json json_of(const PairedErrors& errors) {
  const auto known = [](double value) { return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(); };
  return {{"flights", errors.flights},
          {"before_m", errors.before_m},
          {"after_m", errors.after_m},
          {"difference_m",
           {{"value", errors.difference_m.value},
            {"low", known(errors.difference_m.low)},
            {"high", known(errors.difference_m.high)}}},
          {"verdict", errors.verdict},
          {"within_margin", errors.within_margin}};
}

}  // namespace

identify::Interval mean_with_interval(const std::vector<double>& values) {
  const double mean = mean_value(values);
  double half_width = std::numeric_limits<double>::infinity();
  if (values.size() > 1) {
    double squares = 0.0;
    for (const double value : values) {
      squares += (value - mean) * (value - mean);
    }
    const auto n = static_cast<double>(values.size());
    half_width = student_t(n - 1.0) * std::sqrt(squares / (n - 1.0) / n);
  }
  return {mean, mean - half_width, mean + half_width};
}

PairedErrors compare_pairs(const std::vector<double>& before_m, const std::vector<double>& after_m) {
  PairedErrors out;
  out.flights = static_cast<int>(before_m.size());
  out.before_m = mean_value(before_m);
  out.after_m = mean_value(after_m);
  std::vector<double> differences;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < before_m.size(); ++i) {
    differences.push_back(after_m[i] - before_m[i]);
    ratios.push_back(std::log(std::max(after_m[i], kMin_m) / std::max(before_m[i], kMin_m)));
  }
  out.difference_m = mean_with_interval(differences);
  const identify::Interval ratio = mean_with_interval(ratios);
  out.within_margin = ratio.high <= std::log1p(kNonInferiority);
  if (ratio.high < 0.0) {
    out.verdict = "better";
  } else if (ratio.low > 0.0 && !out.within_margin) {
    out.verdict = "worse";
  }
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

std::string describe(const PairedErrors& errors) {
  std::array<char, 200> text{};
  // Adding 0.0 turns -0.0 into 0.0, which is printed without that sign.
  const auto rounded = [](double m) { return std::round(1e4 * m) / 1e4 + 0.0; };
  const auto& [value, low, high] = errors.difference_m;
  const std::string of =
      errors.flights == 1 ? "spread inside one flight each" : std::to_string(errors.flights) + " pairs";
  if (std::isfinite(low)) {
    std::snprintf(text.data(), text.size(), "%.4f -> %.4f m, %+.4f [%+.4f, %+.4f], %s (%s)", errors.before_m,
                  errors.after_m, rounded(value), rounded(low), rounded(high), errors.verdict.c_str(), of.c_str());
  } else {
    std::snprintf(text.data(), text.size(), "%.4f -> %.4f m, of which the spread is not known", errors.before_m,
                  errors.after_m);
  }
  return text.data();
}

nlohmann::json to_json(const PairedTask& task) {
  nlohmann::json out = json_of(task.pose);
  out["horizontal"] = json_of(task.horizontal);
  out["vertical"] = json_of(task.vertical);
  return out;
}

}  // namespace m100::lab::loop
