// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "host_tests/scenario/sensor_faults/sensor_fault_bench.h"

namespace m100::scenario {

/// Follows the true place with a time constant of `size` seconds.
inline void low_pass(sim::PoseSample& sample, sim::SensorFaultState<sim::PoseSample>& memory, double size) {
  if (memory.kept.empty()) {
    memory.kept.push_back(*memory.first);
  }
  sim::PoseSample& last = memory.kept.back();
  const double passed_s = core::seconds<double>(sample.captured - last.captured);
  last.position_w_m += (sample.position_w_m - last.position_w_m) * std::min(passed_s / size, 1.0);
  last.captured = sample.captured;
  sample.position_w_m = last.position_w_m;
}

inline constexpr sim::SensorFault kLowPass{"low_pass", "low-passed place", 0.2, "s", low_pass};

/// A course whose first step begins at kStepAt_s, inside a square from the start to `side_m` along both axes.
struct MotionCourse {
  const char* words = "";
  double side_m = 0.0;
};

inline constexpr double kStepAt_s = 8.0;
inline constexpr MotionCourse kSquare{
    "step 0 0 0 0 8\nstep 2 0 0 0 6\nstep 2 2 0 0 6\nstep 0 2 0.4 0 6\nstep 0 0 0 0 6\n", 2.0};
inline constexpr MotionCourse kStepsAndTurns{
    "step 0 0 0 0 8\nstep 3 0 0 0 5\nstep 3 0 0 1.5 4\nstep 0 3 0.4 1.5 6\nstep 3 3 0 -1 6\nstep 0 0 0 0 7\n", 3.0};

/// One flight of a course; the fence lies one metre beyond it.
struct MotionFlight {
  const sim::SensorFault* fault = nullptr;
  double size = 0.0;
  double at_s = 0.0;
  link::Channel channel = link::Channel::kVirtualRc;
  int seed = 1;
  Air air = Air::kCalm;
  MotionCourse course = kSquare;
};

struct MotionOutcome {
  double beyond_m = -1e3;  ///< the fence, at most; negative: inside
  double handed_over_m_s = 0.0;
  bool handed_over = false;
  safety::FailsafeStep descent;  ///< why the failsafe first left its top after the fault began
};

inline MotionOutcome outcome_of(const MotionFlight& flight) {
  lab::experiments::FlightPlan plan = plan_in(flight.air, flight.seed);
  plan.course = flight.course.words;
  plan.duration_s = 36.0;
  plan.channel = flight.channel;
  const double side_m = flight.course.side_m;
  const std::string range = "_m = [-1, " + std::to_string(side_m + 1.0) + "]\n";
  plan.flight_file = companion::parse_flight(
      "[fence]\nx" + range + "y" + range + "z_m = [0.3, 3]\n[wind]\nclass_m_s = 5\n", "flight.toml");
  plan.disturb = strikes_at(flight.at_s, *flight.fault, flight.size);
  MotionOutcome outcome;
  plan.operate = [&](const app::FlightController<double>& controller, double t_s) {
    if (t_s > flight.at_s && outcome.descent.reason == safety::FailsafeReason::kNone &&
        controller.supervisor().failsafe_state() != safety::FailsafeState::kNominal) {
      outcome.descent = controller.supervisor().descent();
    }
  };
  const lab::experiments::FlightResult result = lab::experiments::fly(plan);
  for (const lab::experiments::TracePoint& point : result.trace) {
    const double x_m = point.position_m[0] - result.start.position_w_m.x();
    const double y_m = point.position_m[1] - result.start.position_w_m.y();
    outcome.beyond_m =
        std::max({outcome.beyond_m, std::abs(x_m - 0.5 * side_m) - 0.5 * side_m - 1.0,
                  std::abs(y_m - 0.5 * side_m) - 0.5 * side_m - 1.0, std::abs(point.position_m[2] - 1.65) - 1.35});
    outcome.handed_over_m_s = std::hypot(point.velocity_m_s[0], point.velocity_m_s[1]);
    outcome.handed_over =
        point.t_s > flight.at_s && point.failsafe_state == static_cast<int>(safety::FailsafeState::kSilent);
    if (outcome.handed_over) {
      break;
    }
  }
  return outcome;
}

inline void print(const MotionFlight& flight, const MotionOutcome& outcome) {
  std::printf("%s %.3g at %.2f s, channel %d, air %d, seed %d: %.2f m beyond the fence, %.2f m/s\n",
              flight.fault->name.data(), flight.size, flight.at_s, static_cast<int>(flight.channel),
              static_cast<int>(flight.air), flight.seed, outcome.beyond_m, outcome.handed_over_m_s);
}

/// The worst of several flights.
struct MotionWorst {
  int flights = 0;
  int handed_over = 0;
  double beyond_m = -1e3;
  double handed_over_m_s = 0.0;
};

/// Flies a fault of each size at a random moment of the course; every channel in both airs.
template <typename Size>
MotionWorst worst_of(std::string_view fault, int flights, std::uint64_t seed, const MotionCourse& course,
                     const Size& size) {
  sim::Random random(seed, fault);
  MotionWorst worst{.flights = flights};
  for (int i = 0; i < flights; ++i) {
    const double side = random.next() % 2 == 0 ? 1.0 : -1.0;
    const MotionFlight flight{.fault = sim::find_sensor_fault(fault),
                              .size = side * size(i),
                              .at_s = kStepAt_s + 27.0 * random.uniform(),
                              .channel = i % 2 == 0 ? link::Channel::kVirtualRc : link::Channel::kMovement,
                              .seed = static_cast<int>(random.next() % 1000) + 1,
                              .air = i / 2 % 2 == 0 ? Air::kCalm : Air::kWind,
                              .course = course};
    const MotionOutcome outcome = outcome_of(flight);
    print(flight, outcome);
    worst.handed_over += static_cast<int>(outcome.handed_over);
    worst.beyond_m = std::max(worst.beyond_m, outcome.beyond_m);
    worst.handed_over_m_s = std::max(worst.handed_over_m_s, outcome.handed_over ? outcome.handed_over_m_s : 0.0);
  }
  return worst;
}

/// Flies `flights` headings that turn by 20 to 180 degrees to either side while the place stays right.
inline MotionWorst worst_of_headings(int flights, std::uint64_t seed) {
  return worst_of("heading", flights, seed, kStepsAndTurns,
                  [flights](int i) { return 20.0 + 160.0 * i / (flights - 1); });
}

/// Flies `flights` rolls that drift away by 3 to 11 degrees (0.05 to 0.2 rad) within four seconds.
inline MotionWorst worst_of_tilts(int flights, std::uint64_t seed) {
  return worst_of("tilt_ramp", flights, seed, kSquare, [flights](int i) { return 3.0 + 8.4 * i / (flights - 1); });
}

}  // namespace m100::scenario
