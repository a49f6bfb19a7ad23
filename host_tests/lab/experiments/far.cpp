// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/experiments/far.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "host_tests/lab/printed.h"

namespace m100::lab::experiments {
namespace {

constexpr double kRest_s = 2.0;  ///< averaged at a flight's end as place of rest; a settled error must last as long
constexpr double kSettled_m = 0.02;
constexpr double kFar_m = 100.0;

FlightPlan plan_of(const FarTask& task, const SuiteOptions& options) {
  FlightPlan plan = options.plan;
  plan.plant.air.wind_m_s.x() += task.wind_m_s;
  if (task.drag_per_s > 0.0) {
    plan.plant.air.linear_drag_per_s = task.drag_per_s;
  }
  plan.course = task.course;
  plan.duration_s = task.to_s;
  plan.pilot_holds_position = true;
  companion::FlightFile file;
  file.fence_x_m = {-kFar_m, task.fence_high_m > 0.0 ? task.fence_high_m : kFar_m};
  file.fence_y_m = {-kFar_m, kFar_m};
  file.fence_z_m = {-kFar_m, kFar_m};
  file.ground_z_m = -kFar_m - 1.0;
  plan.flight_file = file;
  return plan;
}

/// The range of positions that the reference spans, in x and y [m].
struct ReferenceRange {
  std::array<double, 2> low{}, high{};
};

/// The range over a flight. If a fence blocks the course, the range ends in x where the aircraft came to rest.
ReferenceRange reference_range(const Trace& trace, const FarTask& task) {
  ReferenceRange range;
  auto& [low, high] = range;
  std::array<double, 2> rest{};
  double resting = 0.0;
  for (std::size_t axis = 0; axis < 2 && !trace.empty(); ++axis) {
    low[axis] = high[axis] = trace.front().reference_m[axis];
  }
  for (const TracePoint& point : trace) {
    const bool rests = point.t_s > task.to_s - kRest_s;
    resting += rests ? 1.0 : 0.0;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      low[axis] = std::min(low[axis], point.reference_m[axis]);
      high[axis] = std::max(high[axis], point.reference_m[axis]);
      rest[axis] += rests ? point.position_m[axis] : 0.0;
    }
  }
  if (task.fence_high_m > 0.0 && resting > 0.0) {
    high[0] = std::min(high[0], rest[0] / resting);
  }
  return range;
}

FarScore mean_of_flights(FlightPlan plan, const FarTask& task, const SuiteOptions& options, mpc::Law law,
                         bool plans = false) {
  plan.law = law;
  plan.plans_setpoints = plans;
  FarScore sum;
  for (int i = 0; i < options.seeds; ++i) {
    plan.seed = options.seed + static_cast<std::uint64_t>(i);
    const FlightResult flight = fly(plan);
    if (!flight.flew) {
      continue;
    }
    const FarScore one = far_score(flight.trace, task);
    sum.overshoot_m += one.overshoot_m;
    sum.iae_m_s += one.iae_m_s;
    sum.settled_s += one.settled_s;
    sum.stayed += one.stayed;
    sum.flown += one.flown;
  }
  const double flown = std::max(1, sum.flown);
  sum.overshoot_m /= flown;
  sum.iae_m_s /= flown;
  sum.settled_s /= flown;
  return sum;
}

bool all_flew(const FarResult& result) {
  return result.mpc.flown > 0 && result.lqr.flown > 0 && result.planned.flown > 0;
}

struct Sums {
  double planned = 0.0, mpc = 0.0, lqr = 0.0;
  std::optional<double> gain() const { return lqr > 0.0 ? std::optional(1.0 - mpc / lqr) : std::nullopt; }
};

Sums sum_of(const std::vector<FarResult>& results, double FarScore::*member) {
  Sums sums;
  for (const FarResult& result : results) {
    sums.planned += all_flew(result) ? result.planned.*member : 0.0;
    sums.mpc += all_flew(result) ? result.mpc.*member : 0.0;
    sums.lqr += all_flew(result) ? result.lqr.*member : 0.0;
  }
  return sums;
}

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

std::string row(const std::string& name, const Sums& overshoot, const Sums& iae, const Sums& settled) {
  return printed("%-20s %8.3f %8.3f %8.3f %9.2f %8.2f %8.2f %8.2f %8.2f %8.2f\n", name.c_str(), overshoot.planned,
                 overshoot.mpc, overshoot.lqr, iae.planned, iae.mpc, iae.lqr, settled.planned, settled.mpc,
                 settled.lqr);
}

Sums of(const FarResult& result, double FarScore::*member) {
  return {.planned = result.planned.*member, .mpc = result.mpc.*member, .lqr = result.lqr.*member};
}

}  // namespace

const std::vector<FarTask>& far_tasks() {
  static const std::vector<FarTask> kTasks{
      {.name = "step_10m_tail_wind",
       .course = "step 0 0 0 0 15\nstep 10 0 0 0 30\n",
       .from_s = 15.0,
       .to_s = 35.0,
       .wind_m_s = 9.0,
       .drag_per_s = 0.3},
      {.name = "step_30m", .course = "step 0 0 0 0 10\nstep 30 0 0 0 30\n", .from_s = 10.0, .to_s = 35.0},
      // A minimum-jerk side reaches 15/8 of its mean speed.
      {.name = "square_3m",
       .course = "step 0 0 0 0 10\nsquare 3 1.40625 0.5\nsquare 3 1.40625 0.5\n",
       .from_s = 10.0,
       .to_s = 30.0},
      {.name = "brake_at_fence",
       .course = "step 0 0 0 0 10\npolynomial 10 x 0 4\n",
       .from_s = 12.0,
       .to_s = 25.0,
       .fence_high_m = 20.0},
      {.name = "step_6m", .course = "step 0 0 0 0 10\nstep 6 0 0 0 30\n", .from_s = 10.0, .to_s = 30.0}};
  return kTasks;
}

FarScore far_score(const Trace& trace, const FarTask& task) {
  const ReferenceRange range = reference_range(trace, task);
  FarScore out{.overshoot_m = 0.0, .iae_m_s = 0.0, .stayed = stayed(trace) ? 1 : 0, .flown = trace.empty() ? 0 : 1};
  double before_s = task.from_s;
  for (const TracePoint& point : trace) {
    if (point.t_s < task.from_s || point.t_s >= task.to_s) {
      continue;
    }
    double square_m2 = 0.0;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double at_m = point.position_m[axis];
      out.overshoot_m = std::max({out.overshoot_m, at_m - range.high[axis], range.low[axis] - at_m});
      square_m2 += std::pow(at_m - std::min(point.reference_m[axis], range.high[axis]), 2);
    }
    out.iae_m_s += std::sqrt(square_m2) * (point.t_s - before_s);
    const double since_s = point.t_s - task.from_s;
    const bool is_settled = since_s >= out.settled_s + kRest_s;
    out.settled_s = !is_settled && square_m2 > kSettled_m * kSettled_m ? since_s : out.settled_s;
    before_s = point.t_s;
  }
  return out;
}

std::vector<FarResult> fly_far(const SuiteOptions& options) {
  std::vector<FarResult> results;
  for (const FarTask& task : far_tasks()) {
    if (!options.only.empty() && options.only != task.name) {
      continue;
    }
    const FlightPlan plan = plan_of(task, options);
    results.push_back({.task = &task,
                       .planned = mean_of_flights(plan, task, options, mpc::Law::kMpc, true),
                       .mpc = mean_of_flights(plan, task, options, mpc::Law::kMpc),
                       .lqr = mean_of_flights(plan, task, options, mpc::Law::kLqr),
                       .seeds = options.seeds});
    if (options.progress) {
      options.progress(task.name);
    }
  }
  return results;
}

int not_flown(const std::vector<FarResult>& results) {
  int out = 0;
  for (const FarResult& result : results) {
    out += 3 * result.seeds - result.planned.flown - result.mpc.flown - result.lqr.flown;
  }
  return out;
}

void print_far(std::ostream& out, const std::vector<FarResult>& results) {
  out << "task                 overshoot [m]              integral of |error| [m s]  settled to 2 cm [s]\n"
         "                      planned      MPC      LQR   planned      MPC      LQR  planned      MPC      LQR\n";
  for (const FarResult& result : results) {
    if (all_flew(result)) {
      out << row(result.task->name, of(result, &FarScore::overshoot_m), of(result, &FarScore::iae_m_s),
                 of(result, &FarScore::settled_s));
    } else {
      out << result.task->name << ": not flown! Control was never obtained: planned " << result.planned.flown
          << ", MPC " << result.mpc.flown << ", LQR " << result.lqr.flown << " of " << result.seeds
          << " flights flown\n";
    }
    if (std::min({result.planned.stayed, result.mpc.stayed, result.lqr.stayed}) < result.seeds) {
      out << "  flights that stayed nominal or coasting: planned " << result.planned.stayed << ", MPC "
          << result.mpc.stayed << ", LQR " << result.lqr.stayed << " of " << result.seeds << "\n";
    }
  }
  const Sums overshoot = sum_of(results, &FarScore::overshoot_m);
  const Sums iae = sum_of(results, &FarScore::iae_m_s);
  if (std::any_of(results.begin(), results.end(), all_flew)) {
    out << row("sum", overshoot, iae, sum_of(results, &FarScore::settled_s));
  }
  if (overshoot.gain() && iae.gain()) {
    out << printed("the exact law is better by %.1f %% of overshoot and %.1f %% of the integral\n",
                   100.0 * *overshoot.gain(), 100.0 * *iae.gain());
  }
}

Json far_to_json(const std::vector<FarResult>& results) {
  const auto one = [](const FarScore& score, int seeds) {
    const auto flown = [&](double value) { return score.flown > 0 ? Json(value) : Json(); };
    return Json{{"overshoot_m", flown(score.overshoot_m)},
                {"iae_m_s", flown(score.iae_m_s)},
                {"settled_s", flown(score.settled_s)},
                {"stayed", score.stayed},
                {"not_flown", seeds - score.flown}};
  };
  Json tasks = Json::array();
  for (const FarResult& result : results) {
    tasks.push_back({{"name", result.task->name},
                     {"seeds", result.seeds},
                     {"planned", one(result.planned, result.seeds)},
                     {"mpc", one(result.mpc, result.seeds)},
                     {"lqr", one(result.lqr, result.seeds)}});
  }
  return {{"tasks", tasks},
          {"gain_overshoot", or_null(sum_of(results, &FarScore::overshoot_m).gain())},
          {"gain_iae", or_null(sum_of(results, &FarScore::iae_m_s).gain())}};
}

}  // namespace m100::lab::experiments
