// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/law/geofence_limiter.h"

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
constexpr double kBlend_m = 0.4;   // braking grows to its full size over this distance
constexpr double kBehind_m = 3.0;  // a goal this far behind the aircraft makes the law use all the tilt
constexpr double kSigmas = 3.0;

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
GeofenceLimiter<T>::GeofenceLimiter(const core::Fence& fence, const Braking& braking)
    : braking_(braking),
      x_(side_of(fence.side[core::Fence::kX])),
      y_(side_of(fence.side[core::Fence::kY])),
      z_(side_of(fence.side[core::Fence::kZ])),
      braking_m_s2_(static_cast<T>(braking.acceleration_m_s2)),
      // The next check comes one tick later, so the aircraft may fly on for a tick before the reaction begins.
      reaction_s_(static_cast<T>(braking.reaction_s) + core::seconds<T>(core::kTickPeriod)),
      unknown_drag_per_s_(static_cast<T>(braking.unknown_drag_per_s)),
      wind_m_s2_(static_cast<T>(braking.drag_per_s * fence.wind_m_s)),
      unseen_m_s2_(static_cast<T>(braking.drag_per_s * kGustShare * fence.wind_m_s + est::kForceOffset_m_s2)) {}

template <typename T>
T GeofenceLimiter<T>::stop_m(T speed_m_s, T tilted_m_s2, T wind_m_s2) const {
  // Drag that the vehicle file does not know may hide a part of the wind, but no wind above the fence's wind class.
  // Braking removes this drag, so a third of the hidden part acts on average over the braking distance.
  const T relief_m_s2 = core::clamp(wind_m_s2_ - wind_m_s2, T(0), unknown_drag_per_s_ * speed_m_s);
  const T blows_m_s2 = wind_m_s2 + static_cast<T>(kReliefShare) * relief_m_s2;
  const T disturbance_acceleration_m_s2 = (blows_m_s2 > T(0) ? blows_m_s2 : T(0)) + unseen_m_s2_;
  const T left_m_s2 = braking_m_s2_ - disturbance_acceleration_m_s2;
  constexpr T kMin = static_cast<T>(kMinBraking_m_s2);
  const T braking_m_s2 = left_m_s2 > kMin ? left_m_s2 : kMin;
  const T gaining_s = reaction_s_ - static_cast<T>(kTurnedRound_s);
  const T speed_change_m_s = ((tilted_m_s2 > T(0) ? tilted_m_s2 : T(0)) + disturbance_acceleration_m_s2) * gaining_s;
  const T top_m_s = speed_m_s + speed_change_m_s;
  return speed_m_s * reaction_s_ + speed_change_m_s * (reaction_s_ - T(0.5) * gaining_s) +
         top_m_s * top_m_s / (T(2) * braking_m_s2);
}

template <typename T>
void GeofenceLimiter<T>::update_outside(const Side& side, T position_m) {
  const T below_m = side.low_m - position_m;
  const T above_m = position_m - side.high_m;
  const T beyond_m = below_m > above_m ? below_m : above_m;
  outside_m_ = beyond_m > outside_m_ ? beyond_m : outside_m_;
}

template <typename T>
void GeofenceLimiter<T>::limit_axis(Axis window, const Side& side, const est::AxisEstimate<T>& estimate, T tilt_sign) {
  for (ref::AxisReference<T>& r : window) {
    const T held_m = core::clamp(r.position_m, side.goal_low_m, side.goal_high_m);
    r = held_m == r.position_m ? r : ref::AxisReference<T>{.position_m = held_m};
  }
  const bool up = estimate.velocity_m_s > T(0);
  const T direction = up ? T(1) : T(-1);
  const T speed_m_s = direction * estimate.velocity_m_s;
  const T tilted_m_s2 = direction * tilt_sign * static_cast<T>(model::kGravity_m_s2) * estimate.tilt_rad;
  const T stop = stop_m(speed_m_s, tilted_m_s2, direction * estimate.disturbance_m_s2);
  const T room_m = (up ? side.high_m - estimate.position_m : estimate.position_m - side.low_m) - stop;
  reserve_m_ = room_m < reserve_m_ ? room_m : reserve_m_;
  const T sigma_m = core::sqrt(estimate.position_variance_m2);
  const T share =
      core::clamp((static_cast<T>(kSigmas) * sigma_m - room_m) * static_cast<T>(1.0 / kBlend_m) + T(1), T(0), T(1));
  // Below this speed the reference is not moved behind the aircraft: at rest beside a side nothing has to be braked.
  constexpr T kSlow_m_s = static_cast<T>(0.3);
  if (share <= T(0) || speed_m_s < kSlow_m_s) {
    return;
  }
  brakes_ = true;
  const T behind_m = estimate.position_m - direction * static_cast<T>(kBehind_m);
  for (ref::AxisReference<T>& r : window) {
    r.position_m += share * (behind_m - r.position_m);
    r.velocity_m_s -= share * r.velocity_m_s;
    r.acceleration_m_s2 -= share * r.acceleration_m_s2;
  }
}

template <typename T>
void GeofenceLimiter<T>::limit_goal(ref::Window<T>& window) const {
  const T x_m = core::clamp(window.x[0].position_m, x_.goal_low_m, x_.goal_high_m);
  const T y_m = core::clamp(window.y[0].position_m, y_.goal_low_m, y_.goal_high_m);
  if (window.constant && (x_m != window.x[0].position_m || y_m != window.y[0].position_m)) {
    window.x.fill({.position_m = x_m});
    window.y.fill({.position_m = y_m});
  }
}

template <typename T>
void GeofenceLimiter<T>::limit(ref::Window<T>& window, const est::Estimate<T>& estimate, std::size_t points) {
  brakes_ = false;
  reserve_m_ = static_cast<T>(1e6);
  outside_m_ = static_cast<T>(-1e6);
  update_outside(x_, estimate.x.position_m);
  update_outside(y_, estimate.y.position_m);
  update_outside(z_, estimate.height_m);
  limit_axis(Axis(window.x).first(points), x_, estimate.x, T(1));
  limit_axis(Axis(window.y).first(points), y_, estimate.y, T(-1));
  const T held_m = core::clamp(window.height.position_m, z_.goal_low_m, z_.goal_high_m);
  if (held_m != window.height.position_m) {
    window.height = {.position_m = held_m};
  }
}

template class GeofenceLimiter<float>;
template class GeofenceLimiter<double>;

}  // namespace m100::ctl
