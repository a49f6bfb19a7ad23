// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/experiments/far.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

namespace m100::lab::experiments {
namespace {

constexpr double kRest_s = 2.0;  ///< end of a flight in which the aircraft is taken as at rest
constexpr double kFar_m = 100.0;

FlightPlan plan_of(const FarTask& task, const SuiteOptions& options) {
  FlightPlan plan;
  plan.plant = options.plant;
  plan.plant.air.wind_m_s.x() += task.wind_m_s;
  if (task.drag_per_s > 0.0) {
    plan.plant.air.linear_drag_per_s = task.drag_per_s;
  }
  plan.vehicle = options.vehicle;
  plan.course = task.course;
  plan.duration_s = task.to_s;
  plan.channel = options.channel;
  plan.rate_hz = options.rate_hz;
  plan.pilot_holds_position = true;
  companion::FlightFile file;
  file.fence_x_m = {-kFar_m, task.fence_high_m > 0.0 ? task.fence_high_m : kFar_m};
  file.fence_y_m = {-kFar_m, kFar_m};
  file.fence_z_m = {-kFar_m, kFar_m};
  file.ground_z_m = -kFar_m - 1.0;
  plan.flight_file = file;
  return plan;
}

FarScore mean_of_flights(FlightPlan plan, const FarTask& task, const SuiteOptions& options, mpc::Law law) {
  plan.law = law;
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
    sum.stayed += one.stayed;
    sum.flown += one.flown;
  }
  const double flown = std::max(1, sum.flown);
  sum.overshoot_m /= flown;
  sum.iae_m_s /= flown;
  return sum;
}

bool both_flew(const FarResult& result) { return result.mpc.flown > 0 && result.lqr.flown > 0; }

struct Sums {
  double mpc = 0.0, lqr = 0.0;
  std::optional<double> gain() const { return lqr > 0.0 ? std::optional(1.0 - mpc / lqr) : std::nullopt; }
};

Sums sum_of(const std::vector<FarResult>& results, double FarScore::*member) {
  Sums sums;
  for (const FarResult& result : results) {
    sums.mpc += both_flew(result) ? result.mpc.*member : 0.0;
    sums.lqr += both_flew(result) ? result.lqr.*member : 0.0;
  }
  return sums;
}

nlohmann::json or_null(const std::optional<double>& value) { return value ? nlohmann::json(*value) : nlohmann::json(); }

std::string row(const std::string& name, double mpc_overshoot, double lqr_overshoot, double mpc_iae, double lqr_iae) {
  char line[160];
  std::snprintf(line, sizeof line, "%-28s %10.4f %10.4f %12.3f %12.3f\n", name.c_str(), mpc_overshoot, lqr_overshoot,
                mpc_iae, lqr_iae);
  return line;
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

namespace {

/// The range that the reference spans, per axis.
struct RequestedAcceleration {
  std::array<double, 2> low{}, high{};
};

/// If a fence blocks the course, the range ends at the place where the aircraft rests.
RequestedAcceleration acceleration_for(const Trace& trace, const FarTask& task) {
  RequestedAcceleration asked;
  auto& [low, high] = asked;
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
  return asked;
}

}  // namespace

FarScore far_score(const Trace& trace, const FarTask& task) {
  const RequestedAcceleration asked = acceleration_for(trace, task);
  FarScore out{.overshoot_m = 0.0, .iae_m_s = 0.0, .stayed = stayed(trace) ? 1 : 0, .flown = trace.empty() ? 0 : 1};
  double before_s = task.from_s;
  for (const TracePoint& point : trace) {
    if (point.t_s < task.from_s || point.t_s >= task.to_s) {
      continue;
    }
    double square_m2 = 0.0;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double at_m = point.position_m[axis];
      out.overshoot_m = std::max({out.overshoot_m, at_m - asked.high[axis], asked.low[axis] - at_m});
      square_m2 += std::pow(at_m - std::min(point.reference_m[axis], asked.high[axis]), 2);
    }
    out.iae_m_s += std::sqrt(square_m2) * (point.t_s - before_s);
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
    out += 2 * result.seeds - result.mpc.flown - result.lqr.flown;
  }
  return out;
}

void print_far(std::ostream& out, const std::vector<FarResult>& results) {
  char head[160];
  std::snprintf(head, sizeof head, "%-28s %10s %10s %12s %12s\n", "", "MPC", "LQR", "MPC", "LQR");
  out << "task                          overshoot [m]            integral of |error| [m s]\n" << head;
  for (const FarResult& result : results) {
    if (both_flew(result)) {
      out << row(result.task->name, result.mpc.overshoot_m, result.lqr.overshoot_m, result.mpc.iae_m_s,
                 result.lqr.iae_m_s);
    } else {
      out << result.task->name << ": not flown! Control was never obtained: MPC " << result.mpc.flown << ", LQR "
          << result.lqr.flown << " of " << result.seeds << " flights flown\n";
    }
    if (result.mpc.stayed < result.seeds || result.lqr.stayed < result.seeds) {
      out << "  flights that stayed nominal or coasting: MPC " << result.mpc.stayed << ", LQR " << result.lqr.stayed
          << " of " << result.seeds << "\n";
    }
  }
  const Sums overshoot = sum_of(results, &FarScore::overshoot_m);
  const Sums iae = sum_of(results, &FarScore::iae_m_s);
  if (std::any_of(results.begin(), results.end(), both_flew)) {
    out << row("sum", overshoot.mpc, overshoot.lqr, iae.mpc, iae.lqr);
  }
  if (overshoot.gain() && iae.gain()) {
    char gain[160];
    std::snprintf(gain, sizeof gain, "the exact law is better by %.1f %% of overshoot and %.1f %% of the integral\n",
                  100.0 * *overshoot.gain(), 100.0 * *iae.gain());
    out << gain;
  }
}

nlohmann::json far_to_json(const std::vector<FarResult>& results) {
  const auto one = [](const FarScore& score) {
    const auto flown = [&](double value) { return score.flown > 0 ? nlohmann::json(value) : nlohmann::json(); };
    return nlohmann::json{
        {"overshoot_m", flown(score.overshoot_m)}, {"iae_m_s", flown(score.iae_m_s)}, {"stayed", score.stayed}};
  };
  nlohmann::json tasks = nlohmann::json::array();
  for (const FarResult& result : results) {
    nlohmann::json task{
        {"name", result.task->name}, {"seeds", result.seeds}, {"mpc", one(result.mpc)}, {"lqr", one(result.lqr)}};
    task["mpc"]["not_flown"] = result.seeds - result.mpc.flown;
    task["lqr"]["not_flown"] = result.seeds - result.lqr.flown;
    tasks.push_back(std::move(task));
  }
  return {{"tasks", tasks},
          {"gain_overshoot", or_null(sum_of(results, &FarScore::overshoot_m).gain())},
          {"gain_iae", or_null(sum_of(results, &FarScore::iae_m_s).gain())}};
}

}  // namespace m100::lab::experiments
