// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/experiments/results.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iomanip>

#include "host_tests/lab/on_all_cores.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::experiments {
namespace {

/// The seven rows of the paper's table.
struct Row {
  const char* name;
  const char* unit;
  double Cell::*ours;
  double model::paper::ResultColumn::*papers;
  bool tilt;
};
const std::vector<Row>& rows() {
  using Column = model::paper::ResultColumn;
  static const std::vector<Row> all{{"pose", "m", &Cell::pose_m, &Column::pose_m, false},
                                    {"x", "m", &Cell::x_m, &Column::x_m, false},
                                    {"y", "m", &Cell::y_m, &Column::y_m, false},
                                    {"z", "m", &Cell::z_m, &Column::z_m, false},
                                    {"roll", "deg", &Cell::roll_deg, &Column::roll_deg, true},
                                    {"pitch", "deg", &Cell::pitch_deg, &Column::pitch_deg, true},
                                    {"yaw", "deg", &Cell::yaw_deg, &Column::yaw_deg, false}};
  return all;
}

std::string fixed(double value, int digits) { return printed("%.*f", digits, value); }

double paper_value(const TaskResult& result, const Row& row) {
  return result.task->paper != nullptr ? result.task->paper->*row.papers : -1.0;
}

bool is_compared(const TaskResult& result, const Row& row) {
  return paper_value(result, row) >= 0.0 && (!row.tilt || result.task->tilt_counts);
}

/// The plan's flights, one for each seed, in turn if they share a body. Only the first may keep its log.
std::vector<FlightResult> fly_seeds(const FlightPlan& plan, const SuiteOptions& options) {
  std::vector<FlightResult> out(static_cast<std::size_t>(options.seeds));
  const std::size_t at_once = plan.body == nullptr ? out.size() : 1;
  on_all_cores(at_once, [&](std::size_t first) {
    for (std::size_t i = first; i < out.size(); i += at_once) {
      FlightPlan own = plan;
      own.seed = options.seed + i;
      own.keep_log = i == 0 && plan.keep_log;
      out[i] = fly(own);
    }
  });
  return out;
}

/// The mean of the task's flights with the plan's law; empty: it never obtained control. Adds to the simulated time and
/// the baselines' refused flights of `result`.
std::optional<Cell> baseline_of(const FlightPlan& plan, const Task& task, const SuiteOptions& options,
                                TaskResult& result) {
  std::vector<Cell> cells;
  for (const FlightResult& flight : fly_seeds(plan, options)) {
    result.simulated_s += flight.simulated_s;
    if (flight.flew) {
      cells.push_back(score(flight.trace, task.from_s, task.to_s));
    }
  }
  result.baselines_refused += options.seeds - static_cast<int>(cells.size());
  return cells.empty() ? std::nullopt : std::optional(mean_of(cells));
}

/// The plant of a task. Without a body, tasks in wind have the fan. With one, they have the plant's wind, others none.
sim::Plant plant_of(const Task& task, const SuiteOptions& options) {
  sim::Plant plant = options.plan.plant;
  if (options.plan.body == nullptr) {
    return task.fan ? sim::with_fan(plant) : plant;
  }
  plant.air.wind_m_s *= task.fan ? 1.0 : 0.0;
  return plant;
}

/// For comparison with the flown error of steps: the error of the fastest motion that the tilt limit allows.
void compare_with_time_optimal(const Task& task, double tilt_limit_rad, TaskResult& result) {
  result.time_optimal_m = time_optimal_rms_m(task.steps_m, tilt_limit_rad, task.to_s - task.from_s);
  const double ours = std::hypot(result.mean.x_m, result.mean.y_m);
  result.time_optimal_share = ours > 0.0 ? result.time_optimal_m / ours : 0.0;
}

TaskResult fly_task(const Task& task, const SuiteOptions& options) {
  TaskResult result;
  result.task = &task;
  std::vector<Cell> cells;
  FlightPlan plan = options.plan;
  plan.plant = plant_of(task, options);
  plan.course = task.course;
  plan.duration_s = task.to_s + 1.0;
  plan = options.paper_law ? in_paper_configuration(plan) : plan;
  plan.keep_log = bool(options.keep_log);
  const std::vector<FlightResult> flights = fly_seeds(plan, options);
  for (const FlightResult& flight : flights) {
    result.simulated_s += flight.simulated_s;
    result.seconds_per_flight += flight.computer_time_s / options.seeds;
    result.largest_tilt_deg = std::max(result.largest_tilt_deg, flight.largest_tilt_deg);
    result.touchdown_speed_m_s = std::max(result.touchdown_speed_m_s, flight.touchdown_speed_m_s);
    if (!flight.flew) {
      ++result.refused;
      continue;
    }
    cells.push_back(score(flight.trace, task.from_s, task.to_s));
    const bool is_first = &flight == &flights.front();
    if (is_first && plan.keep_log) {
      options.keep_log(task, std::string(flight.log.begin(), flight.log.end()));
    }
    if (is_first) {
      for (std::size_t k = 0; k < flight.trace.size(); k += 5) {
        result.trace.push_back(flight.trace[k]);
      }
    }
  }
  if (options.baseline) {
    plan.keep_log = false;
    FlightPlan other = plan;
    other.law = mpc::Law::kLqr;
    result.baseline = baseline_of(other, task, options, result);
    result.paper_law = baseline_of(in_paper_configuration(plan), task, options, result);
  }
  result.seeds = options.seeds;
  result.mean = mean_of(cells);
  result.spread = spread_of(cells);
  result.flights = cells;
  if (!task.steps_m.empty() && result.flown()) {
    compare_with_time_optimal(task, options.plan.vehicle.vehicle.translation.tilt_limit_rad, result);
  }
  return result;
}

/// Null for a cell that was never flown: its error is unknown, not zero.
Json json_of(const Cell& cell, bool flown = true) {
  Json out;
  for (const CellField& field : cell_fields()) {
    out[field.name] = flown ? Json(cell.*field.member) : Json();
  }
  return out;
}

void print_papers_line(std::ostream& out, const TaskResult& result) {
  if (result.task->paper == nullptr) {
    return;
  }
  out << std::left << std::setw(12) << result.task->task << std::setw(8) << "paper" << std::right;
  for (const Row& row : rows()) {
    const double papers = paper_value(result, row);
    out << std::setw(18) << (papers < 0.0 ? "---" : fixed(papers, 3));
  }
  out << "\n";
}

void print_our_line(std::ostream& out, const TaskResult& result) {
  const Task& task = *result.task;
  out << std::left << std::setw(12) << (task.task == "simulator" ? "  course" : "  " + task.condition) << std::setw(8)
      << "ours" << std::right;
  for (const Row& row : rows()) {
    if (!result.flown()) {
      out << std::setw(18) << "not flown!";
      continue;
    }
    const bool above = is_compared(result, row) && result.mean.*row.ours > paper_value(result, row);
    out << std::setw(18)
        << (fixed(result.mean.*row.ours, 4) +
            (result.seeds > 1 ? " +-" + fixed(result.spread.*row.ours, 4) : std::string()) + (above ? "!" : " "));
  }
}

/// Prints the results that the paper's table does not have.
void print_more(std::ostream& out, const TaskResult& result) {
  const Task& task = *result.task;
  out << "\n"
      << std::left << std::setw(20) << "" << std::right << "  tilt " << fixed(result.mean.tilt_deg, 2)
      << " deg, command moves " << fixed(result.mean.input_variation_deg_s, 1) << " deg/s, worst "
      << fixed(result.mean.worst_m, 3) << " m";
  if (result.time_optimal_m > 0.0) {
    out << ", time-optimal " << fixed(result.time_optimal_m, 3) << " m, reached "
        << fixed(100.0 * result.time_optimal_share, 0) << " %";
  }
  if (task.paper == nullptr) {
    out << "  (" << task.task << ")";
  }
  for (const auto& [law, cell] :
       {std::pair{"clipped LQR", &result.baseline}, std::pair{"--law paper", &result.paper_law}}) {
    if (*cell) {
      out << "\n"
          << std::setw(20) << ""
          << "  " << law << ": pose " << fixed((*cell)->pose_m, 4) << " m, command moves "
          << fixed((*cell)->input_variation_deg_s, 1) << " deg/s, worst " << fixed((*cell)->worst_m, 3) << " m";
    }
  }
  if (result.mean.off_nominal_share > 0.0 || result.refused > 0) {
    out << ", off the failsafe's top " << fixed(100.0 * result.mean.off_nominal_share, 2) << " %, not flown "
        << result.refused;
  }
  out << "\n";
}

void put_comparison(const TaskResult& result, Json& cell) {
  Json papers;
  for (const Row& row : rows()) {
    if (paper_value(result, row) >= 0.0) {
      papers[std::string(row.name) + "_" + row.unit] = paper_value(result, row);
    }
  }
  cell["paper"] = papers;
  std::vector<std::string> above;
  const std::vector<PaperComparison> cells = compared(result);
  for (const PaperComparison& one : cells) {
    if (one.above) {
      above.push_back(one.name);
    }
  }
  cell["compared"] = cells.size();
  cell["above_paper"] = above;
}

}  // namespace

std::vector<TaskResult> fly_suite(const SuiteOptions& options) {
  std::vector<TaskResult> results;
  for (const auto* const tasks : {&paper_tasks(), &literal_steps()}) {
    for (const Task& task : *tasks) {
      if ((!options.only.empty() && options.only != task.task) ||
          (tasks == &literal_steps() && !options.literal_steps)) {
        continue;
      }
      results.push_back(fly_task(task, options));
      if (options.progress) {
        options.progress(task.task + " " + task.condition + ": pose " + fixed(results.back().mean.pose_m, 4) + " m, " +
                         fixed(results.back().seconds_per_flight, 2) + " s of computer per flight");
      }
    }
  }
  return results;
}

std::vector<PaperComparison> compared(const TaskResult& result) {
  std::vector<PaperComparison> out;
  for (const Row& row : rows()) {
    if (is_compared(result, row)) {
      out.push_back({std::string(row.name) + "_" + row.unit,
                     !result.flown() || result.mean.*row.ours > paper_value(result, row)});
    }
  }
  return out;
}

int cells_above_paper(const std::vector<TaskResult>& results) {
  int above = 0;
  for (const TaskResult& result : results) {
    above += static_cast<int>(std::ranges::count_if(compared(result), &PaperComparison::above));
  }
  return above;
}

std::string above_words(const std::vector<TaskResult>& results) {
  std::string out;
  for (const TaskResult& result : results) {
    for (const PaperComparison& cell : compared(result)) {
      out += cell.above
                 ? (out.empty() ? " (" : "; ") + result.task->task + ", " + result.task->condition + ": " + cell.name
                 : "";
    }
  }
  return out + (out.empty() ? "" : ")");
}

void print_table(std::ostream& out, const std::vector<TaskResult>& results) {
  if (results.empty()) {
    return;
  }
  out << "Root mean square errors. 'paper': measured by its authors in flight (last column: their simulator).\n"
         "'ours': SIMULATED, "
      << (results.front().seeds > 1
              ? "mean and standard deviation over " + std::to_string(results.front().seeds) + " seeds"
              : std::string("one seed"))
      << ".\n\n";
  out << std::left << std::setw(20) << "" << std::right;
  for (const Row& row : rows()) {
    out << std::setw(18) << (std::string(row.name) + " [" + row.unit + "]");
  }
  out << "\n";
  for (const TaskResult& result : results) {
    print_papers_line(out, result);
    print_our_line(out, result);
    print_more(out, result);
  }
  out << "\nCells above the paper's: " << cells_above_paper(results) << above_words(results) << "\n";
}

Json to_json(const std::vector<TaskResult>& results) {
  Json out;
  for (const TaskResult& result : results) {
    Json cell = json_of(result.mean, result.flown());
    cell["spread"] = json_of(result.spread, result.flown());
    for (const auto& [name, share] : {std::pair{"low", 0.05}, std::pair{"median", 0.5}, std::pair{"high", 0.95}}) {
      cell[name] = json_of(quantile_of(result.flights, share), result.flown());
    }
    cell["seeds"] = result.seeds;
    cell["not_flown"] = result.refused;
    cell["largest_tilt_deg"] = result.largest_tilt_deg;
    cell["hardest_touch_m_s"] = result.touchdown_speed_m_s;
    cell["seconds_per_flight"] = result.seconds_per_flight;
    cell["simulated"] = true;
    if (result.baseline) {
      cell["lqr"] = json_of(*result.baseline);
    }
    if (result.paper_law) {
      cell["paper_law"] = json_of(*result.paper_law);
    }
    if (result.time_optimal_m > 0.0) {
      cell["time_optimal_m"] = result.time_optimal_m;
      cell["time_optimal_share"] = result.time_optimal_share;
    }
    if (result.task->paper != nullptr) {
      put_comparison(result, cell);
    }
    out[result.task->task][result.task->condition] = cell;
  }
  out["cells_above_paper"] = results.empty() ? Json() : Json(cells_above_paper(results));
  return out;
}

}  // namespace m100::lab::experiments
