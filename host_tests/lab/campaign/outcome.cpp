// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/campaign/outcome.h"

#include <algorithm>
#include <cmath>

#include "firmware/core/maths.h"
#include "firmware/safety/failsafe.h"
#include "host_tests/lab/campaign/oscillation.h"
#include "host_tests/lab/experiments/score.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::campaign {
namespace {

using experiments::FlightPlan;
using experiments::FlightResult;
using experiments::TracePoint;
using safety::FailsafeState;

FlightPlan plan_of(const sim::Plant& world, const Task& task, std::uint64_t seed, const Settings& settings) {
  FlightPlan plan = settings.plan;
  plan.plant = world;
  plan.course = task.course;
  plan.duration_s = task.duration_s;
  plan.seed = seed;
  plan.pilot_holds_position = true;
  plan.flight_file = flight_file_of(task, sim::WorldOptions{}.position_w_m.z());
  return settings.paper_law ? in_paper_configuration(plan) : plan;
}

/// The coordinate by which the aircraft is outside the fence, as a sentence; empty: it is inside.
std::string breached_limit(const TracePoint& point, const FlightResult& flight, const companion::FlightFile& file) {
  const auto beyond = [](const char* axis, double value, const companion::Range& range) {
    return range.contains(value)
               ? std::string()
               : printed("%s = %.2f m is outside the fence [%.2f, %.2f]", axis, value, range.low, range.high);
  };
  std::string x = beyond("x", point.position_m[0] - flight.start.position_w_m.x(), file.fence_x_m);
  std::string y = beyond("y", point.position_m[1] - flight.start.position_w_m.y(), file.fence_y_m);
  return !x.empty() ? x : !y.empty() ? y : beyond("z", point.position_m[2], file.fence_z_m);
}

double tilt_deg(const TracePoint& point) {
  return std::acos(std::cos(point.roll_rad) * std::cos(point.pitch_rad)) * core::kRadian_deg;
}

bool below_coast(const TracePoint& point) {
  const auto failsafe_state = static_cast<FailsafeState>(point.failsafe_state);
  return failsafe_state != FailsafeState::kNominal && failsafe_state != FailsafeState::kCoast;
}

/// Time after the handover to the pilot for which the motion still counts as the controller's.
constexpr double kAftermath_s = 2.0;

void record_tick(const TracePoint& point, Outcome& out) {
  const auto failsafe_state = static_cast<FailsafeState>(point.failsafe_state);
  out.coasted = out.coasted || failsafe_state == FailsafeState::kCoast;
  out.released = out.released || failsafe_state == FailsafeState::kRelease || failsafe_state == FailsafeState::kSilent;
  out.worst_tilt_deg = std::max(out.worst_tilt_deg, tilt_deg(point));
  if (point.nees >= 0.0 && out.why.empty()) {
    out.nees_sum += point.nees;
    ++out.nees_count;
  }
}

/// Records the first failure of a flight, and all its events until kAftermath_s after the handover.
void judge(const FlightResult& flight, const companion::FlightFile& file, Outcome& out) {
  double silent_since_s = -1.0;
  for (const TracePoint& point : flight.trace) {
    if (static_cast<FailsafeState>(point.failsafe_state) == FailsafeState::kSilent && silent_since_s < 0.0) {
      silent_since_s = point.t_s;
      out.handed_over_m_s = std::hypot(point.velocity_m_s[0], point.velocity_m_s[1]);
    }
    if (silent_since_s >= 0.0 && point.t_s > silent_since_s + kAftermath_s) {
      break;
    }
    record_tick(point, out);
    const std::string side = breached_limit(point, flight, file);
    out.breached = out.breached || !side.empty();
    if (out.why.empty() && (below_coast(point) || !side.empty())) {
      out.failed_at_s = point.t_s;
      out.why = !side.empty() ? side : "below coast: " + flight.descent;
    }
  }
}

experiments::Trace until(const experiments::Trace& trace, double end_s) {
  const auto behind = std::find_if(trace.begin(), trace.end(), [&](const TracePoint& p) { return p.t_s >= end_s; });
  return {trace.begin(), behind};
}

}  // namespace

sim::Plant nominal_world(const sim::Plant& world) {
  sim::Plant kind = sim::measured_plant();
  kind.air = world.air;
  kind.payload = world.payload;
  kind.change = world.change;
  kind.mass_kg = world.mass_kg;
  return kind;
}

Outcome fly_one(const sim::Plant& world, const Task& task, std::uint64_t seed, const Settings& settings,
                sim::BodyJob* body) {
  FlightPlan plan = plan_of(world, task, seed, settings);
  plan.body = body;
  const FlightResult flight = experiments::fly(plan);
  Outcome out;
  if (!flight.flew) {
    out.why = "never flew: " + flight.authority;
    return out;
  }
  judge(flight, *plan.flight_file, out);
  out.limit_cycle_detected_s = flight.limit_cycle_detected_s;
  out.contradicted = flight.contradicted;
  out.model_mismatch = flight.model_mismatch;
  out.refused_poses = flight.refused_poses;
  out.latency_error_s = flight.pose_age_error_s;
  out.latency_sigma_s = flight.pose_timing.sigma_s;
  out.stayed = out.why.empty();
  const double until_s = out.stayed ? task.duration_s : out.failed_at_s;
  const experiments::Cell cell = experiments::score(flight.trace, 0.0, until_s);
  out.scored = until_s > 0.0;
  out.nis_sum = out.stayed ? flight.nis_sum : 0.0;
  out.nis_count = out.stayed ? flight.nis_count : 0;
  out.pose_rms_m = cell.pose_m;
  out.tilt_rms_deg = cell.tilt_deg;
  out.command_deg_s = cell.input_variation_deg_s;
  const experiments::Trace trace = until(flight.trace, until_s);
  TiltOscillation flown = measure_oscillation(trace);
  if (!is_surely_steady(flown, task.hovers)) {
    const FlightResult reference = experiments::fly(plan_of(nominal_world(world), task, seed, settings));
    const experiments::Trace kind = until(reference.trace, until_s);
    // A course that repeats (the squares, at 0.33 Hz) gives the tilt its period, which is no oscillation of the loop.
    flown.periodic = flown.periodic && (task.hovers || measure_oscillation(trace, kind).periodic);
    out.oscillated = oscillates(flown, measure_oscillation(kind), task.hovers);
  }
  // If the flight detected a limit cycle, the fallback law may have ended it so early that the trace looks steady.
  out.oscillated = out.oscillated || flight.limit_cycle_detected_s >= 0.0;
  return out;
}

std::string log_of(const sim::Plant& world, const Task& task, std::uint64_t seed, const Settings& settings,
                   sim::BodyJob* body) {
  FlightPlan plan = plan_of(world, task, seed, settings);
  plan.body = body;
  plan.start = experiments::fly(plan).start;
  plan.keep_log = true;
  const FlightResult flight = experiments::fly(plan);
  return flight.flew ? std::string(flight.log.begin(), flight.log.end()) : std::string();
}

}  // namespace m100::lab::campaign
