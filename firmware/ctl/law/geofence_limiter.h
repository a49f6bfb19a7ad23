// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>

#include "firmware/core/fence.h"
#include "firmware/ctl/law/braking.h"
#include "firmware/ctl/law/geofence_status.h"
#include "firmware/est/estimate.h"
#include "firmware/ref/window.h"

namespace m100::ctl {

/// Holds the reference inside the fence. In x and y it also limits the speed so that the aircraft can stop before a
/// side.
///
/// Stopping distance on one horizontal axis, at a speed v towards a side:
///   v t + a0 s (t - s / 2) + (v + a0 s)^2 / (2 a)
/// where t is the reaction time until the attitude is reversed, s = t - 0.05 s the time until it passes level, and
///   a  = braking - p,  at least 0.05 m/s^2,   p = gusts + force offset + the wind that blows towards the side
///   a0 = p + the acceleration of the present tilt towards the side.
/// The gusts are those of the fence's wind class. The wind is the estimated one, plus a third of what drag may hide of
/// it.
///
/// If position plus stopping distance plus three sigmas of the position end beyond the side or less than 0.4 m before
/// it, and the speed is at least 0.3 m/s, the reference is moved gradually to a point behind the aircraft. The law then
/// brakes.
template <typename T>
class GeofenceLimiter {
 public:
  GeofenceLimiter(const core::Fence& fence, const Braking& braking);

  /// Moves a constant reference in x and y inside if it is beyond a side or too near to it. Call it before a motion to
  /// it is planned.
  void limit_goal(ref::Window<T>& window) const;
  /// Limits the reference. @param points number of points in x and y that are limited, beginning with the first.
  void limit(ref::Window<T>& window, const est::Estimate<T>& estimate, std::size_t points = ref::kHorizon + 1);
  /// Of the last limit(): distance from the point where the aircraft can stop to the side towards which it flies,
  /// without the three sigmas; the smaller of x and y. Negative: the aircraft may stop too late.
  T reserve_m() const { return reserve_m_; }
  /// Of the last limit(): how far the estimate is beyond the nearest side, floor or ceiling; negative: inside.
  T outside_m() const { return outside_m_; }
  GeofenceStatus status() const {
    return {.reserve_m = static_cast<double>(reserve_m_), .outside_m = static_cast<double>(outside_m_)};
  }
  const Braking& braking() const { return braking_; }
  /// Of the last limit(): the reference was moved because of the speed.
  bool brakes() const { return brakes_; }

 private:
  struct Side {
    T low_m, high_m;            ///< of the fence
    T goal_low_m, goal_high_m;  ///< for the reference
  };
  using Axis = std::span<ref::AxisReference<T>>;
  static Side side_of(const core::Fence::Side& side);
  /// Stopping distance at a speed towards a side; acceleration by tilt and by wind, positive towards that side.
  T stop_m(T speed_m_s, T tilted_m_s2, T wind_m_s2) const;
  void update_outside(const Side& side, T position_m);
  void limit_axis(Axis window, const Side& side, const est::AxisEstimate<T>& estimate, T tilt_sign);

  Braking braking_;
  Side x_, y_, z_;
  T braking_m_s2_, reaction_s_, unknown_drag_per_s_;
  T wind_m_s2_;    ///< acceleration by a wind of the fence's class
  T unseen_m_s2_;  ///< acceleration by its gusts, and the error of the estimated wind while no pose arrives
  T reserve_m_{0};
  T outside_m_{0};
  bool brakes_ = false;
};

extern template class GeofenceLimiter<float>;
extern template class GeofenceLimiter<double>;

}  // namespace m100::ctl
