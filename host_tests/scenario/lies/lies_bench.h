// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
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
constexpr double kStruckAt_s = 10.0;  ///< two seconds after the tasks' first step
constexpr double kFromStart = -1.0;
constexpr double kShort_s = 10.0;  ///< duration of a flight whose channel lies from the start

enum class Air { kCalm, kWind };

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

/// One flight of a task with a lie, or with none (null).
struct LyingFlight {
  const sim::Lie* lie = nullptr;
  double size = 0.0;
  const char* task = "hover";
  double from_s = kStruckAt_s;
  Air air = Air::kCalm;
};

inline lab::experiments::FlightResult flown(const LyingFlight& flight, int seed) {
  const lab::campaign::Task task = lab::campaign::tasks_of(flight.task).front();
  lab::experiments::FlightPlan plan;
  plan.plant = plant_in(flight.air);
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  plan.course = task.course;
  plan.duration_s = flight.from_s < 0.0 ? kShort_s : task.duration_s;
  plan.seed = static_cast<std::uint64_t>(seed);
  plan.pilot_holds_place = true;
  plan.looks_first = flight.from_s < 0.0;
  if (flight.lie == nullptr) {
    return lab::experiments::fly(plan);
  }
  const auto strike = [&flight](sim::World& world) { world.lie(*flight.lie, flight.size); };
  if (flight.from_s < 0.0) {
    plan.prepare = strike;
  } else {
    plan.disturb = [strike, from_s = flight.from_s, struck = false](sim::World& world, double t_s) mutable {
      if (!struck && t_s >= from_s) {
        struck = true;
        strike(world);
      }
    };
  }
  return lab::experiments::fly(plan);
}

/// The flight without a lie; each is flown once for all lies.
inline const lab::experiments::FlightResult& honestly_flown(const LyingFlight& flight, int seed) {
  static std::map<std::tuple<std::string, bool, Air, int>, lab::experiments::FlightResult> kept;
  const auto key = std::make_tuple(std::string(flight.task), flight.from_s < 0.0, flight.air, seed);
  const auto found = kept.find(key);
  if (found != kept.end()) {
    return found->second;
  }
  LyingFlight honest = flight;
  honest.lie = nullptr;
  return kept.emplace(key, flown(honest, seed)).first->second;
}

struct Noticed {
  double after_s = kNever;  ///< after the lie began; 0 if control was not taken at all
  double away_m = 0.0;      ///< distance from the honest flight at that time, or at its end
  double farthest_m = 0.0;  ///< until the pilot had the sticks
  double speed_m_s = 0.0;   ///< horizontal, at that time
  bool refused = false;     ///< control was not taken
};

inline Noticed noticed(const LyingFlight& flight, int seed) {
  const lab::experiments::FlightResult& honest = honestly_flown(flight, seed);
  const lab::experiments::FlightResult told = flown(flight, seed);
  Noticed out;
  if (!told.flew) {
    out.after_s = 0.0;
    out.refused = true;
    return out;
  }
  for (std::size_t i = 0; i < std::min(honest.trace.size(), told.trace.size()); ++i) {
    const lab::experiments::TracePoint& point = told.trace[i];
    const auto& a = honest.trace[i].position_m;
    const auto& b = point.position_m;
    if (out.after_s != kNever && point.rung == static_cast<int>(safety::Rung::kSilent)) {
      break;
    }
    const double away_m = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    out.farthest_m = std::max(out.farthest_m, away_m);
    out.speed_m_s = std::hypot(point.velocity_m_s[0], point.velocity_m_s[1]);
    if (out.after_s == kNever) {
      out.away_m = away_m;
      if (point.rung != static_cast<int>(safety::Rung::kNominal)) {
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
  Noticed of{.after_s = 0.0};

  void note(const Noticed& found) {
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
    char text[96];
    if (missed == seeds) {
      static_cast<void>(std::snprintf(text, sizeof text, "never, %.2f m", of.away_m));
    } else {
      static_cast<void>(std::snprintf(text, sizeof text, "%d of %d, %.1f s, %.2f m (%.2f m)", seeds - missed, seeds,
                                      of.after_s, of.away_m, of.farthest_m));
    }
    return text;
  }
  /// Columns of a table.
  std::string text() const {
    char text[128];
    if (refused == seeds) {
      static_cast<void>(std::snprintf(text, sizeof text, "%d of %d | control is not taken | - | - | -", seeds, seeds));
    } else {
      static_cast<void>(std::snprintf(text, sizeof text, "%d of %d | %.1f s | %.2f m | %.2f m | %.2f m/s",
                                      seeds - missed, seeds, of.after_s, of.away_m, of.farthest_m, of.speed_m_s));
    }
    return text;
  }
};

/// A lie, and the range in which the smallest size is searched that is noticed with every seed.
struct SizedLie {
  const char* name;
  const char* lie;
  const char* task;
  double small;
  double large;
};

/// @returns columns of a table; "none" if not even the largest size is noticed with every seed.
inline std::string smallest(const SizedLie& sized, int seeds) {
  const sim::Lie* const lie = sim::lie_of(sized.lie);
  const auto worst_of = [&](double size) {
    Worst worst;
    for (int seed = 1; seed <= seeds && worst.missed == 0; ++seed) {
      worst.note(noticed({.lie = lie, .size = size, .task = sized.task}, seed));
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
  char text[96];
  static_cast<void>(std::snprintf(text, sizeof text, "%.2g %s | %.1f s | %.2f m | %.2f m", seen, lie->unit.data(),
                                  worst.of.after_s, worst.of.away_m, worst.of.farthest_m));
  return text;
}

}  // namespace m100::scenario
