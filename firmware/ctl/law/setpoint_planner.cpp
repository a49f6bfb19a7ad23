// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/setpoint_planner.h"

#include <algorithm>
#include <span>

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"

namespace m100::ctl {
namespace {

/// No motion is planned if the goal is nearer than this [m] and the speed lower [m/s].
constexpr double kMinGoal_m = 0.05;
constexpr double kMinShare = 0.25;   ///< least share of the slope limit for an axis
constexpr int kHalvings = 8;         ///< of the range in which the braking is sought: to 0.4 % of it
constexpr double kAtGoal_m = 0.001;  ///< a stop this far beyond the goal counts as one at the goal

template <typename T>
T magnitude(T value) {
  return value < T(0) ? -value : value;
}

}  // namespace

template <typename T>
typename SetpointPlanner<T>::Axis SetpointPlanner<T>::make_axis(const mpc::GainTable<T>& table) {
  const T up = table.input_gain * table.input_max_slope;
  const T down = -table.input_gain * table.input_min_slope;
  return {.max_slope = up < down ? up : down, .per_slope_m_s2 = table.tilt_sign * table.acceleration_per_tilt};
}

template <typename T>
[[gnu::cold]] SetpointPlanner<T>::SetpointPlanner(const Braking& braking, const mpc::GainTables<T>& tables,
                                                  T combined_slope)
    : x_(make_axis(tables.x)),
      y_(make_axis(tables.y)),
      combined_slope_(combined_slope),
      braking_(braking),
      reaction_s_(static_cast<T>(braking.reaction_s)) {}

template <typename T>
T SetpointPlanner<T>::measured_m_s2(const Axis& axis, const est::AxisEstimate<T>& estimate) const {
  return axis.per_slope_m_s2 * core::tan(estimate.tilt_rad) + estimate.disturbance_m_s2;
}

/// The state ahead_s from now, at the present acceleration.
template <typename T>
ref::AxisReference<T> SetpointPlanner<T>::measured(const Axis& axis, const est::AxisEstimate<T>& estimate,
                                                   T ahead_s) const {
  const T acceleration_m_s2 = measured_m_s2(axis, estimate);
  const T faster_m_s = ahead_s * acceleration_m_s2;
  return {.position_m = estimate.position_m + ahead_s * (estimate.velocity_m_s + T(0.5) * faster_m_s),
          .velocity_m_s = estimate.velocity_m_s + faster_m_s,
          .acceleration_m_s2 = acceleration_m_s2};
}

template <typename T>
ref::AxisLimits<T> SetpointPlanner<T>::limits(const Axis& axis, const est::AxisEstimate<T>& estimate,
                                              const ref::AxisReference<T>& from,
                                              const GeofenceLimiter<T>& fence) const {
  const T wind_m_s2 =
      estimate.disturbance_m_s2 + static_cast<T>(1.0 / 3.0) * (axis.at_rest_m_s2 - estimate.disturbance_m_s2);
  ref::AxisLimits<T> limits =
      motion_limits(braking_, magnitude(axis.per_slope_m_s2) * axis.slope, axis.authority, wind_m_s2);
  limits.braking_share = static_cast<T>(kBrakingShare);

  const typename GeofenceLimiter<T>::Side& side = &axis == &x_ ? fence.x() : fence.y();
  const bool up = axis.goal_m > from.position_m;
  const T direction = up ? T(1) : T(-1);
  const T room_m = direction * ((up ? side.goal_high_m : side.goal_low_m) - axis.goal_m);
  const T up_m_s2 = up ? limits.up_m_s2 : limits.down_m_s2;
  const T down_m_s2 = up ? limits.down_m_s2 : limits.up_m_s2;
  const T most_m_s2 = limits.braking_share * down_m_s2;
  const T way_m = magnitude(axis.goal_m - from.position_m) + T(0.5) * from.velocity_m_s * from.velocity_m_s / up_m_s2;
  // An order to stop acts one reaction time later: until then the aircraft may still accelerate.
  const T late_m_s = reaction_s_ * up_m_s2;
  T lower_m_s2 = most_m_s2;
  for (int pass = 0; pass < 2; ++pass) {  // the second with the top speed of the motion that the first one found
    const T top_m_s = core::sqrt(T(2) * way_m * up_m_s2 * lower_m_s2 / (up_m_s2 + lower_m_s2));
    const T share = top_m_s / (top_m_s + late_m_s);
    const T short_s2 =
        way_m / (share * share * fence.sure_braking_m_s2(top_m_s, direction * wind_m_s2)) - room_m / up_m_s2;
    if (way_m + room_m >= most_m_s2 * short_s2) {
      return limits;
    }
    lower_m_s2 = (way_m + room_m) / short_s2;
  }
  T low = lower_m_s2 / down_m_s2, high = limits.braking_share;
  limits.braking_share = low;
  const auto passes_goal = [&] {
    return direction * (ref::TimeOptimal<T>::stop_m(from, limits) - axis.goal_m) > static_cast<T>(kAtGoal_m);
  };
  // The aircraft may already be too near for this braking: then the least that still stops at the goal.
  for (int halving = 0; halving < kHalvings && (halving > 0 || passes_goal()); ++halving) {
    limits.braking_share = T(0.5) * (low + high);
    (passes_goal() ? low : high) = limits.braking_share;
    limits.braking_share = high;
  }
  return limits;
}

template <typename T>
void SetpointPlanner<T>::set_goals(T x_m, T y_m, const est::Estimate<T>& estimate) {
  if (follows_ && x_m == x_.goal_m && y_m == y_.goal_m) {
    return;
  }
  const T away_x_m = magnitude(x_m - estimate.x.position_m);
  const T away_y_m = magnitude(y_m - estimate.y.position_m);
  const T away_m = std::max(core::sqrt(away_x_m * away_x_m + away_y_m * away_y_m), static_cast<T>(kMinGoal_m));
  set_goal(x_, estimate.x, x_m, away_x_m / away_m);
  set_goal(y_, estimate.y, y_m, away_y_m / away_m);
  follows_ = true;
}

/// @param share component of the direction to the goal along this axis, 0 to 1
template <typename T>
void SetpointPlanner<T>::set_goal(Axis& axis, const est::AxisEstimate<T>& estimate, T goal_m, T share) {
  if (follows_ && goal_m == axis.goal_m) {
    return;
  }
  const T slope = std::max(share, static_cast<T>(kMinShare)) * combined_slope_;
  axis.slope = slope < axis.max_slope ? slope : axis.max_slope;
  axis.goal_m = goal_m;
  axis.at_rest_m_s2 = estimate.disturbance_m_s2;
  axis.authority = T(1);
  axis.replans = 0;
  const bool is_far = magnitude(goal_m - estimate.position_m) > static_cast<T>(kMinGoal_m) ||
                      magnitude(estimate.velocity_m_s) > static_cast<T>(kMinGoal_m);
  axis.is_due = is_far;
  axis.is_off = !follows_;
  if (!is_far) {
    axis.motion.rest(goal_m);
  }
}

/// Orders a new plan if the aircraft has left the motion or the disturbance has changed. Does nothing in the first
/// reaction time and after the end of the motion.
template <typename T>
void SetpointPlanner<T>::check(Axis& axis, const est::AxisEstimate<T>& estimate, T time_s, T lead_s) {
  if (time_s < reaction_s_ || time_s > axis.motion.duration_s()) {
    return;
  }
  const T error_m = estimate.position_m - axis.motion.at(time_s - lead_s).position_m;
  axis.is_off = axis.is_off || magnitude(error_m) > static_cast<T>(kMaxError_m);
  const bool has_changed = magnitude(estimate.disturbance_m_s2 - axis.planned_m_s2) > static_cast<T>(kMaxChange_m_s2);
  if ((!axis.is_off && !has_changed) || axis.is_due || axis.replans >= kMaxReplans) {
    return;
  }
  ++axis.replans;
  axis.is_due = true;
  if (axis.is_off) {
    learn_authority(axis, estimate, time_s - lead_s);
  }
}

/// If the plan has held one large acceleration for a reaction time, multiplies the axis' authority by the ratio of
/// measured to commanded acceleration.
template <typename T>
void SetpointPlanner<T>::learn_authority(Axis& axis, const est::AxisEstimate<T>& estimate, T time_s) const {
  const T planned_m_s2 = axis.motion.at(time_s).acceleration_m_s2;
  const T before_m_s2 = axis.motion.at(time_s - reaction_s_).acceleration_m_s2;
  const T tilted_m_s2 = magnitude(axis.per_slope_m_s2) * axis.slope;
  const T commanded_m_s2 = planned_m_s2 - estimate.disturbance_m_s2;
  if (planned_m_s2 != before_m_s2 || magnitude(commanded_m_s2) < T(0.5) * tilted_m_s2) {
    return;
  }
  const T share = (measured_m_s2(axis, estimate) - estimate.disturbance_m_s2) / commanded_m_s2;
  axis.authority = core::clamp(axis.authority * share, static_cast<T>(kMinAuthority), T(1));
}

template <typename T>
bool SetpointPlanner<T>::plan_if_due(Axis& axis, const est::AxisEstimate<T>& estimate, const GeofenceLimiter<T>& fence,
                                     core::TimePoint now, T lead_s) {
  if (!axis.is_due) {
    return false;
  }
  const ref::AxisReference<T> from =
      axis.is_off ? measured(axis, estimate, lead_s) : axis.motion.at(core::seconds<T>(now - axis.begin));
  axis.motion.plan(from, axis.goal_m, limits(axis, estimate, from, fence));
  axis.begin = now;
  axis.planned_m_s2 = estimate.disturbance_m_s2;
  axis.is_due = axis.is_off = false;
  return true;
}

template <typename T>
void SetpointPlanner<T>::update(ref::Window<T>& window, const est::Estimate<T>& estimate,
                                const GeofenceLimiter<T>& fence, core::TimePoint now, core::Duration lead,
                                std::size_t points) {
  M100_ASSERT(points >= 1 && points <= window.x.size());
  if (!window.constant) {
    reset();
    return;
  }
  const T lead_s = core::seconds<T>(lead);
  set_goals(fence.x().nearest_goal_m(window.x[0].position_m), fence.y().nearest_goal_m(window.y[0].position_m),
            estimate);
  check(x_, estimate.x, core::seconds<T>(now - x_.begin), lead_s);
  check(y_, estimate.y, core::seconds<T>(now - y_.begin), lead_s);
  if (!plan_if_due(x_, estimate.x, fence, now, lead_s)) {
    plan_if_due(y_, estimate.y, fence, now, lead_s);
  }
  const T x_s = core::seconds<T>(now - x_.begin);
  const T y_s = core::seconds<T>(now - y_.begin);
  window.constant = !y_.is_due && x_s >= x_.motion.duration_s() && y_s >= y_.motion.duration_s();
  if (!window.constant) {
    x_.motion.fill(std::span(window.x).first(points), x_s);
    y_.motion.fill(std::span(window.y).first(points), y_s);
  }
}

template class SetpointPlanner<float>;
template class SetpointPlanner<double>;

}  // namespace m100::ctl
