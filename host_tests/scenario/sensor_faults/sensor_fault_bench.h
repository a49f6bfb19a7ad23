// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <string>
#include <tuple>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/campaign/tasks.h"
#include "host_tests/lab/experiments/flight.h"

namespace m100::scenario {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kFaultAt_s = 9.0;  ///< one second after the tasks' first step
constexpr double kFromStart = -1.0;
constexpr double kShort_s = 10.0;  ///< duration of a flight whose channel lies from the start

enum class Air { kCalm, kWind };

/// As std::printf, into a text of at most 255 characters.
template <typename... Values>
std::string printed(const char* format, Values... values) {
  std::array<char, 256> text{};
  static_cast<void>(std::snprintf(text.data(), text.size(), format, values...));
  return text.data();
}

/// The measured plant; with wind, in worse conditions: wind of 5 m/s with gusts of 30 % and turbulence of 15 %, the
/// drag of an aircraft fully exposed to it, and poses with up to 10 ms of jitter.
inline sim::Plant plant_in(Air air) {
  sim::Plant plant = sim::measured_plant();
  if (air == Air::kWind) {
    plant.air.linear_drag_per_s = 0.3;
    plant.air.wind_m_s = {4.0, -3.0, 0.0};
    plant.air.gust_m_s = 1.5;
    plant.air.turbulence_m_s = 0.75;
    plant.pose.jitter_s = 0.010;
  }
  return plant;
}

/// A flight in this air whose pilot holds the place before control is taken.
inline lab::experiments::FlightPlan plan_in(Air air, int seed) {
  lab::experiments::FlightPlan plan;
  plan.plant = plant_in(air);
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  plan.seed = static_cast<std::uint64_t>(seed);
  plan.pilot_holds_position = true;
  return plan;
}

/// For FlightPlan::disturb: starts the fault at a time of the course.
inline auto strikes_at(double at_s, const sim::SensorFault& fault, double size) {
  return [&fault, size, at_s, struck = false](sim::World& world, double t_s) mutable {
    if (!struck && t_s >= at_s) {
      struck = true;
      world.fault(fault, size);
    }
  };
}

/// One flight of a task with a sensor fault, or with none (null).
struct FaultedFlight {
  const sim::SensorFault* fault = nullptr;
  double size = 0.0;
  const char* task = "hover";
  double from_s = kFaultAt_s;
  Air air = Air::kCalm;
};

inline lab::experiments::FlightResult flown(const FaultedFlight& flight, int seed) {
  const lab::campaign::Task task = lab::campaign::tasks_of(flight.task).front();
  lab::experiments::FlightPlan plan = plan_in(flight.air, seed);
  plan.course = task.course;
  plan.duration_s = flight.from_s < 0.0 ? kShort_s : task.duration_s;
  plan.checks_poses_first = flight.from_s < 0.0;
  if (flight.fault != nullptr && flight.from_s < 0.0) {
    plan.prepare = [&flight](sim::World& world) { world.fault(*flight.fault, flight.size); };
  } else if (flight.fault != nullptr) {
    plan.disturb = strikes_at(flight.from_s, *flight.fault, flight.size);
  }
  return lab::experiments::fly(plan);
}

/// The flight without a sensor fault; each is flown once for all lies.
inline const lab::experiments::FlightResult& flown_without_fault(const FaultedFlight& flight, int seed) {
  static std::map<std::tuple<std::string, bool, Air, int>, lab::experiments::FlightResult> recorded;
  const auto key = std::make_tuple(std::string(flight.task), flight.from_s < 0.0, flight.air, seed);
  const auto found = recorded.find(key);
  if (found != recorded.end()) {
    return found->second;
  }
  FaultedFlight fault_free = flight;
  fault_free.fault = nullptr;
  return recorded.emplace(key, flown(fault_free, seed)).first->second;
}

struct Detection {
  double after_s = kNever;  ///< after the sensor fault began; 0 if control was not taken at all
  double away_m = 0.0;      ///< distance from the honest flight at that time, or at its end
  double farthest_m = 0.0;  ///< until the pilot had the sticks
  double speed_m_s = 0.0;   ///< horizontal, at that time
  bool refused = false;     ///< control was not taken
};

inline Detection detected(const FaultedFlight& flight, int seed) {
  const lab::experiments::FlightResult& fault_free = flown_without_fault(flight, seed);
  const lab::experiments::FlightResult faulted = flown(flight, seed);
  Detection out;
  if (!faulted.flew) {
    out.after_s = 0.0;
    out.refused = true;
    return out;
  }
  for (std::size_t i = 0; i < std::min(fault_free.trace.size(), faulted.trace.size()); ++i) {
    const lab::experiments::TracePoint& point = faulted.trace[i];
    const auto& a = fault_free.trace[i].position_m;
    const auto& b = point.position_m;
    if (out.after_s != kNever && point.failsafe_state == static_cast<int>(safety::FailsafeState::kSilent)) {
      break;
    }
    const double away_m = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    out.farthest_m = std::max(out.farthest_m, away_m);
    out.speed_m_s = std::hypot(point.velocity_m_s[0], point.velocity_m_s[1]);
    if (out.after_s == kNever) {
      out.away_m = away_m;
      if (point.failsafe_state != static_cast<int>(safety::FailsafeState::kNominal)) {
        out.after_s = point.t_s - std::max(flight.from_s, 0.0);
      }
    }
  }
  return out;
}

/// The worst of several seeds.
struct Worst {
  int seeds = 0;
  int missed = 0;
  int refused = 0;
  Detection of{.after_s = 0.0};

  void note(const Detection& found) {
    ++seeds;
    missed += found.after_s == kNever ? 1 : 0;
    refused += found.refused ? 1 : 0;
    of.after_s = found.after_s == kNever ? of.after_s : std::max(of.after_s, found.after_s);
    of.away_m = std::max(of.away_m, found.away_m);
    if (found.after_s != kNever) {
      of.farthest_m = std::max(of.farthest_m, found.farthest_m);
      of.speed_m_s = std::max(of.speed_m_s, found.speed_m_s);
    }
  }
  /// One cell of a table: time and distance of the notice, and in brackets the distance until the pilot had control.
  std::string cell() const {
    if (refused == seeds) {
      return "not taken";
    }
    return missed == seeds
               ? printed("never, %.2f m", of.away_m)
               : printed("%d/%d, %.1f s, %.2f m (%.2f m)", seeds - missed, seeds, of.after_s, of.away_m, of.farthest_m);
  }
  /// Columns of a table.
  std::string text() const {
    return refused == seeds ? printed("%d of %d | control is not taken | - | - | -", seeds, seeds)
                            : printed("%d of %d | %.1f s | %.2f m | %.2f m | %.2f m/s", seeds - missed, seeds,
                                      of.after_s, of.away_m, of.farthest_m, of.speed_m_s);
  }
};

/// A sensor fault, and the range in which the smallest size is searched that is noticed with every seed.
struct SizedFault {
  const char* name;
  const char* fault;
  const char* task;
  double small;
  double large;
};

/// @returns columns of a table; "none" if not even the largest size is noticed with every seed.
inline std::string smallest_detected(const SizedFault& sized, int seeds) {
  const sim::SensorFault* const fault = sim::find_sensor_fault(sized.fault);
  const auto worst_of = [&](double size) {
    Worst worst;
    for (int seed = 1; seed <= seeds && worst.missed == 0; ++seed) {
      worst.note(detected({.fault = fault, .size = size, .task = sized.task}, seed));
    }
    return worst;
  };
  double unseen = sized.small, seen = sized.large;
  Worst worst = worst_of(seen);
  if (worst.missed > 0) {
    return "none";
  }
  for (int halving = 0; halving < 7; ++halving) {
    const double middle = std::sqrt(unseen * seen);
    const Worst found = worst_of(middle);
    (found.missed > 0 ? unseen : seen) = middle;
    worst = found.missed > 0 ? worst : found;
  }
  return printed("%.2g %s | %.1f s | %.2f m | %.2f m", seen, fault->unit.data(), worst.of.after_s, worst.of.away_m,
                 worst.of.farthest_m);
}

}  // namespace m100::scenario
