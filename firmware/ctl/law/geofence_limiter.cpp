// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/geofence_limiter.h"

#include <algorithm>
#include <chrono>

#include "firmware/core/maths.h"
#include "firmware/model/vehicle.h"

namespace m100::ctl {
namespace {

constexpr double kGoalMargin_m = 0.2;         // from a side to the nearest goal: overshoot and tracking error
constexpr double kLargestMarginShare = 0.25;  // of the width between two sides: in a narrow box the margin is smaller
// The attitude passes level this long before it is reversed; from then on the speed no longer grows.
constexpr double kTurnedRound_s = 0.05;
// Least braking that is assumed, where wind, gusts and offset leave less: then almost no speed is admitted.
constexpr double kMinBraking_m_s2 = 0.05;
constexpr double kGustShare = 0.3;  // amplitude of the gusts, as a share of the wind class
constexpr double kReliefShare = 1.0 / 3.0;
constexpr double kSigmas = 3.0;
// A goal this far behind the aircraft makes the law use all the tilt, whatever disturbance it believes in.
constexpr double kBehind_m = 3.0;
constexpr double kSlow_m_s = 0.3;  // at rest beside a side nothing has to be braked
// The shortest stop: the attitude is reversed twice (0.7 s) and the estimate shows that nothing else has to be braked.
constexpr core::Duration kShortestStop = std::chrono::seconds(1);

}  // namespace

template <typename T>
typename GeofenceLimiter<T>::Side GeofenceLimiter<T>::side_of(const core::Fence::Side& side) {
  const double width_m = side.high_m - side.low_m;
  const double margin_m = kGoalMargin_m < kLargestMarginShare * width_m ? kGoalMargin_m : kLargestMarginShare * width_m;
  return {.low_m = static_cast<T>(side.low_m),
          .high_m = static_cast<T>(side.high_m),
          .goal_low_m = static_cast<T>(side.low_m + margin_m),
          .goal_high_m = static_cast<T>(side.high_m - margin_m)};
}

template <typename T>
typename GeofenceLimiter<T>::Side GeofenceLimiter<T>::narrowed(const Side& side, const core::Fence::Side& other) {
  const auto low_m = static_cast<double>(side.low_m), high_m = static_cast<double>(side.high_m);
  return side_of(
      {.low_m = low_m > other.low_m ? low_m : other.low_m, .high_m = high_m < other.high_m ? high_m : other.high_m});
}

template <typename T>
[[gnu::cold]] void GeofenceLimiter<T>::intersect(const core::Fence& other) {
  x_.side = narrowed(x_.side, other.side[core::Fence::kX]);
  y_.side = narrowed(y_.side, other.side[core::Fence::kY]);
  z_ = narrowed(z_, other.side[core::Fence::kZ]);
}

template <typename T>
GeofenceLimiter<T>::GeofenceLimiter(const core::Fence& fence, const Braking& braking)
    : braking_(braking),
      x_{.side = side_of(fence.side[core::Fence::kX]), .tilt_sign = T(1)},
      y_{.side = side_of(fence.side[core::Fence::kY]), .tilt_sign = T(-1)},
      z_(side_of(fence.side[core::Fence::kZ])),
      // The next check comes one tick later, so the aircraft may fly on for a tick before the reaction begins.
      reaction_s_(static_cast<T>(braking.reaction_s) + core::seconds<T>(core::kTickPeriod)),
      wind_m_s2_(static_cast<T>(braking.drag_per_s * fence.wind_m_s)),
      unseen_m_s2_(static_cast<T>(braking.drag_per_s * kGustShare * fence.wind_m_s + est::kForceOffset_m_s2)) {}

/// Drag that the vehicle file does not know may hide a part of the wind, but no wind above the fence's wind class.
/// Braking removes this drag, so a third of the hidden part acts on average over the braking distance.
template <typename T>
T GeofenceLimiter<T>::blowing_m_s2(T speed_m_s, T wind_m_s2) const {
  const T hidden_m_s2 =
      core::clamp(wind_m_s2_ - wind_m_s2, T(0), static_cast<T>(braking_.unknown_drag_per_s) * speed_m_s);
  return std::max(wind_m_s2 + static_cast<T>(kReliefShare) * hidden_m_s2, T(0));
}

template <typename T>
T GeofenceLimiter<T>::sure_braking_m_s2(T speed_m_s, T wind_m_s2) const {
  return std::max(static_cast<T>(braking_.acceleration_m_s2) - blowing_m_s2(speed_m_s, wind_m_s2) - unseen_m_s2_,
                  static_cast<T>(kMinBraking_m_s2));
}

/// From where the aircraft can stop to the side towards which it flies.
/// @param ahead its state lead_s from now @param window the reference that it follows; none: one at rest
template <typename T>
T GeofenceLimiter<T>::room_m(const Axis& axis, const est::AxisEstimate<T>& estimate, const ref::AxisReference<T>& ahead,
                             std::span<const ref::AxisReference<T>> window, T lead_s) const {
  const bool up = estimate.velocity_m_s > T(0);
  const T direction = up ? T(1) : T(-1);
  const T speed_m_s = direction * estimate.velocity_m_s;
  const T wind_m_s2 = direction * estimate.disturbance_m_s2;
  const T left_s = std::max(reaction_s_ - lead_s, T(0));
  const T gaining_s = std::max(left_s - static_cast<T>(kTurnedRound_s), T(0));
  const ref::AxisReference<T> now = window.empty() ? ref::AxisReference<T>{} : window[0];
  const ref::AxisReference<T> then = window.empty() ? now : ref::between<T>(window, left_s);

  // A reference that the aircraft passes within one reaction time sets its tilt.
  const T off_m = ahead.position_m - now.position_m;
  const T passed_m = now.velocity_m_s * reaction_s_;
  const bool follows = off_m * off_m < passed_m * passed_m;
  const T tilted_m_s2 = direction * (ahead.acceleration_m_s2 - estimate.disturbance_m_s2);
  const T towards_m_s2 = follows ? T(0) : std::max(tilted_m_s2 + blowing_m_s2(speed_m_s, wind_m_s2), T(0));
  const T added_m_s = (towards_m_s2 + unseen_m_s2_) * gaining_s;
  const T faster_m_s = direction * (ahead.velocity_m_s - now.velocity_m_s);
  const T top_m_s = std::max(direction * then.velocity_m_s + faster_m_s + added_m_s, T(0));
  const T moves_m =
      direction * (then.position_m - now.position_m) + faster_m_s * left_s + added_m_s * (left_s - T(0.5) * gaining_s);
  const T to_side_m = direction * ((up ? axis.side.high_m : axis.side.low_m) - ahead.position_m);
  return to_side_m - moves_m - top_m_s * top_m_s / (T(2) * sure_braking_m_s2(speed_m_s, wind_m_s2));
}

template <typename T>
void GeofenceLimiter<T>::update_outside(const Side& side, T position_m) {
  const T below_m = side.low_m - position_m;
  const T above_m = position_m - side.high_m;
  const T beyond_m = below_m > above_m ? below_m : above_m;
  outside_m_ = beyond_m > outside_m_ ? beyond_m : outside_m_;
}

template <typename T>
void GeofenceLimiter<T>::limit_axis(Points window, Axis& axis, const est::AxisEstimate<T>& estimate,
                                    core::TimePoint now, T lead_s, const est::AxisEstimate<T>* flown_by) {
  for (ref::AxisReference<T>& r : window) {
    const T held_m = axis.side.nearest_goal_m(r.position_m);
    r = held_m == r.position_m ? r : ref::AxisReference<T>{.position_m = held_m};
  }
  const T gravity_m_s2 = axis.tilt_sign * static_cast<T>(model::kGravity_m_s2);
  const ref::AxisReference<T> ahead = ref::after(
      {estimate.position_m, estimate.velocity_m_s, gravity_m_s2 * estimate.tilt_rad + estimate.disturbance_m_s2},
      lead_s, gravity_m_s2 * estimate.tilt_rate_rad_s);
  axis.reserve_m = room_m(axis, estimate, ahead, {}, lead_s);
  const bool slow = estimate.velocity_m_s < T(kSlow_m_s) && estimate.velocity_m_s > T(-kSlow_m_s);
  if (window.size() > ref::kHorizon) {
    const T sigmas_m = static_cast<T>(kSigmas) * core::sqrt(estimate.position_variance_m2);
    if (axis.stops) {
      axis.stops = !slow || now - axis.begin < kShortestStop;
    } else if (!slow && axis.reserve_m < sigmas_m &&
               (flown_by != nullptr || room_m(axis, estimate, ahead, window, lead_s) < sigmas_m)) {
      const ref::AxisLimits<T> limits =
          motion_limits(braking_, static_cast<T>(braking_.acceleration_m_s2), T(1), estimate.disturbance_m_s2);
      axis.stop.plan(ahead, axis.side.nearest_goal_m(ref::TimeOptimal<T>::stop_m(ahead, limits)), limits);
      axis.begin = now;
      axis.stops = true;
      ++stops_;
    }
  }
  if (axis.stops && flown_by != nullptr) {
    const T behind_m = slow ? T(0) : static_cast<T>(estimate.velocity_m_s > T(0) ? kBehind_m : -kBehind_m);
    std::fill(window.begin(), window.end(), ref::AxisReference<T>{.position_m = flown_by->position_m - behind_m});
  } else if (axis.stops) {
    axis.stop.fill(window, core::seconds<T>(now - axis.begin));
  }
}

template <typename T>
void GeofenceLimiter<T>::limit(ref::Window<T>& window, const est::Estimate<T>& estimate, core::TimePoint now,
                               core::Duration lead, std::size_t points, const est::Estimate<T>* flown_by) {
  outside_m_ = static_cast<T>(-1e6);
  update_outside(x_.side, estimate.x.position_m);
  update_outside(y_.side, estimate.y.position_m);
  update_outside(z_, estimate.height_m);
  const T lead_s = core::seconds<T>(lead);
  limit_axis(Points(window.x).first(points), x_, estimate.x, now, lead_s, flown_by != nullptr ? &flown_by->x : nullptr);
  limit_axis(Points(window.y).first(points), y_, estimate.y, now, lead_s, flown_by != nullptr ? &flown_by->y : nullptr);
  window.constant = window.constant && !brakes();
  const T held_m = z_.nearest_goal_m(window.height.position_m);
  if (held_m != window.height.position_m) {
    window.height = {.position_m = held_m};
  }
}

template <typename T>
void GeofenceLimiter<T>::reset() {
  x_.stops = y_.stops = false;
  stops_ = 0;
}

template class GeofenceLimiter<float>;
template class GeofenceLimiter<double>;

}  // namespace m100::ctl
