// SPDX-License-Identifier: BSD-3-Clause
// Counts the instructions of single solves of one axis under callgrind; mpc_instructions.sh runs it and prints the
// distribution. Every solve is one dump; the trigger line of the dump names the path of the solution.
//   mpc_instructions flight double|float     closed loop as flown; hover, steps, sinusoids, segments, preview jumps
//   mpc_instructions setpoint double|float   only the flights with a constant reference
//   mpc_instructions cold double|float FILE  the instances of a file, each from an empty active set
#include <valgrind/callgrind.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "firmware/mpc/delay_predictor.h"
#include "firmware/mpc/generated/gain_table.h"
#include "firmware/mpc/horizontal_mpc.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/gains/instances.h"

namespace m100 {
namespace {

template <typename T>
mpc::Problem<T> problem_in(const mpc::Problem<double>& problem) {
  if constexpr (std::is_same_v<T, double>) {
    return problem;
  } else {
    return lab::gains::to_float(problem);
  }
}

unsigned most_changes = 0;

template <typename T>
void measure(mpc::HorizontalMpc<T>& controller, const mpc::Problem<T>& problem, mpc::Solution<T>& solution,
             bool preview) {
  CALLGRIND_ZERO_STATS;
  if (preview) {
    controller.solve_preview(problem, solution);
  } else {
    controller.solve(problem, solution);
  }
  switch (solution.path) {  // literals, because building a string here would be counted
    case mpc::Path::kSetpoint:
      CALLGRIND_DUMP_STATS_AT("setpoint");
      break;
    case mpc::Path::kTable:
      CALLGRIND_DUMP_STATS_AT("table");
      break;
    case mpc::Path::kActiveSet:
      CALLGRIND_DUMP_STATS_AT("active_set");
      break;
    case mpc::Path::kClipped:
      CALLGRIND_DUMP_STATS_AT("clipped");
      break;
  }
  most_changes = std::max<unsigned>(most_changes, solution.changes);
}

/// One axis at 100 Hz whose parameters differ a little from the controller's model.
class Flight {
 public:
  using Path = std::function<double(double)>;

  Flight(const model::Vehicle& believed, unsigned seed, bool wind) : random_(seed), wind_(wind) {
    w_ = 1.08 * believed.pitch.natural_frequency_rad_s;
    damping_ = 0.9 * believed.pitch.damping_ratio;
    delay_ticks_ = static_cast<std::size_t>(std::lround(believed.pitch.transport_delay_s / 0.01)) + 1;
    sent_.assign(64, 0.0);
  }

  void step(double input) {
    sent_.insert(sent_.begin(), input);
    sent_.pop_back();
    gust_ += 0.01 * (-gust_) + (wind_ ? 0.5 * std::sqrt(0.02) * normal_(random_) : 0.0);
    disturbance_ = (wind_ ? 1.5 : 0.0) + gust_;
    for (int i = 0; i < 10; ++i) {
      constexpr double kStep_s = 1e-3;
      const double acting = sent_.at(delay_ticks_);
      rate_ += kStep_s * (w_ * w_ * (acting - tilt_) - 2 * damping_ * w_ * rate_);
      tilt_ += kStep_s * rate_;
      v_ += kStep_s * (model::kGravity_m_s2 * std::tan(tilt_) - 0.01 * v_ + disturbance_);
      p_ += kStep_s * v_;
    }
    seen_disturbance_ += 0.02 * (disturbance_ - seen_disturbance_);
  }
  mpc::AxisState<double> seen() {
    return {.position_m = p_ + 0.002 * normal_(random_),
            .velocity_m_s = v_ + 0.02 * normal_(random_),
            .tilt_slope = tilt_ + 0.005 * normal_(random_),
            .tilt_slope_per_s = rate_ + 0.02 * normal_(random_),
            .disturbance_m_s2 = seen_disturbance_,
            .input_offset_slope = 0.0};
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  bool wind_;
  double w_, damping_;
  std::size_t delay_ticks_;
  std::vector<double> sent_;
  double p_ = 0, v_ = 0, tilt_ = 0, rate_ = 0, gust_ = 0, disturbance_ = 0, seen_disturbance_ = 0;
};

struct Task {
  const char* name;
  Flight::Path position;
  bool preview;  ///< the reference is known ahead; otherwise the present set point fills the horizon
};

double quintic(double s) { return s <= 0 ? 0 : s >= 1 ? 1 : s * s * s * (10 + s * (6 * s - 15)); }

std::vector<Task> tasks() {
  const auto zigzag = [](double t) { return 2.0 * (std::fmod(t, 5.0) < 2.5 ? 1.0 : 0.0); };
  return {{"hover", [](double) { return 0.0; }, false},
          {"step 1 m", [](double t) { return t < 1 ? 0.0 : 1.0; }, false},
          {"step 6 m", [](double t) { return t < 1 ? 0.0 : 6.0; }, false},
          {"sinusoid", [](double t) { return 2.0 * std::sin(0.9 * t); }, true},
          {"fast sinusoid", [](double t) { return 2.0 * std::sin(1.8 * t); }, true},
          {"segments", [](double t) { return 3.0 * (quintic(t / 2.5 - 0.4) - quintic(t / 2.5 - 1.4)); }, true},
          {"preview jumps", zigzag, true}};
}

mpc::Problem<double> problem_of(const Task& task, double now_s, const mpc::AxisState<double>& seen,
                                const std::array<double, mpc::kMaxStates>& state, double previous) {
  mpc::Problem<double> problem;
  problem.state = state;
  problem.previous_input_slope = previous;
  problem.disturbance_m_s2 = seen.disturbance_m_s2;
  for (std::size_t k = 0; k < mpc::kHorizon; ++k) {
    const double t = task.preview ? now_s + 0.1 * static_cast<double>(k + 1) : now_s;
    problem.position_ref_m.at(k) = task.position(t);
    problem.velocity_ref_m_s.at(k) = task.preview ? (task.position(t + 1e-3) - task.position(t - 1e-3)) / 2e-3 : 0.0;
    if (std::abs(problem.velocity_ref_m_s.at(k)) > 20) {
      problem.velocity_ref_m_s.at(k) = 0;  // the reference jumps here
    }
  }
  problem.tilt_ref_slope.fill(-seen.disturbance_m_s2 / model::kGravity_m_s2);
  problem.input_ref_slope = problem.tilt_ref_slope;
  problem.constant_targets = true;
  problem.constant_reference = !task.preview;
  return problem;
}

template <typename T>
void fly(bool constant_only) {
  const model::Vehicle& vehicle = mpc::generated::kVehicle;
  for (const Task& task : tasks()) {
    for (const bool wind : {false, true}) {
      if (constant_only && task.preview) {
        continue;
      }
      Flight flight(vehicle, 11, wind);
      mpc::DelayPredictor<double> predictor(mpc::generated::kX<double>.delay);
      mpc::HorizontalMpc<T> controller(mpc::generated::kX<T>);
      double previous = 0.0;
      for (int tick = 0; tick < 300; ++tick) {
        const double now_s = 0.01 * tick + core::seconds<double>(predictor.lead());
        const mpc::AxisState<double> seen = flight.seen();
        const mpc::Problem<T> problem = problem_in<T>(problem_of(task, now_s, seen, predictor.predict(seen), previous));
        mpc::Solution<T> solution;
        measure(controller, problem, solution, false);
        previous = static_cast<double>(solution.input_slope[0]);
        predictor.sent(previous);
        flight.step(previous);
      }
    }
  }
}

template <typename T>
void cold(const std::string& path) {
  std::ifstream stream(path);
  const lab::gains::InstanceFile file = lab::gains::read_instances(stream, path);
  std::vector<mpc::GainTable<T>> tables;
  std::vector<std::unique_ptr<mpc::HorizontalMpc<T>>> controllers;
  tables.reserve(file.models.size());
  for (const lab::gains::AxisQp& model : file.models) {
    tables.push_back(lab::gains::table_in<T>(lab::gains::make_gain_table(model)));
    controllers.push_back(std::make_unique<mpc::HorizontalMpc<T>>(tables.back()));
  }
  for (const lab::gains::Instance& instance : file.instances) {
    mpc::HorizontalMpc<T>& controller = *controllers.at(instance.model);
    controller.reset();
    mpc::Solution<T> solution;
    measure(controller, problem_in<T>(instance.problem), solution, true);
  }
}

template <typename T>
int run(const std::string& what, const std::string& path) {
  std::printf("working memory of one axis: %zu bytes\n", sizeof(mpc::HorizontalMpc<T>));
  if (what == "flight" || what == "setpoint") {
    fly<T>(what == "setpoint");
  } else if (what == "cold" && !path.empty()) {
    cold<T>(path);
  } else {
    return 2;
  }
  std::printf("most changes of the active set: %u\n", most_changes);
  return 0;
}

}  // namespace
}  // namespace m100

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: mpc_instructions flight|setpoint|cold double|float [FILE]\n");
    return 2;
  }
  const std::string path = argc > 3 ? argv[3] : "";
  return std::string(argv[2]) == "float" ? m100::run<float>(argv[1], path) : m100::run<double>(argv[1], path);
}
