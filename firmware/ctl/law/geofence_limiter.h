// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/fence.h"
#include "firmware/core/maths.h"
#include "firmware/core/time.h"
#include "firmware/ctl/law/braking.h"
#include "firmware/ctl/law/geofence_status.h"
#include "firmware/est/estimate.h"
#include "firmware/ref/time_optimal.h"
#include "firmware/ref/window.h"

namespace m100::ctl {

/// Holds the reference inside the fence. In x and y it also stops an aircraft that could soon no longer stop before a
/// side.
///
/// Where the aircraft stops on one horizontal axis if full braking is ordered now: it acts one reaction time t from
/// now. Until then it follows the reference, whose position and speed towards the side are p and v then, with its
/// present deviation (e, e_v). So a motion that brakes in time is admitted. It stops at
///   p + e + e_v t + g (t - s / 2) + (v + e_v + g)^2 / (2 a),   g = (b + u) s,   a = sure_braking_m_s2()
/// s = t - 0.05 s is the time until the attitude passes level, u the gusts and the force offset, b the acceleration by
/// tilt and wind, at least 0; b = 0 where the aircraft passes the place of the reference within t, which sets its tilt.
///
/// If this place and three sigmas of the position are beyond the side, and the speed is at least 0.3 m/s, the reference
/// is replaced by a planned stop. It is followed until the speed is lower than that, and for at least 1 s.
template <typename T>
class GeofenceLimiter {
 public:
  struct Side {
    T low_m, high_m;            ///< of the fence
    T goal_low_m, goal_high_m;  ///< for the reference
    T nearest_goal_m(T goal_m) const { return core::clamp(goal_m, goal_low_m, goal_high_m); }
  };

  GeofenceLimiter(const core::Fence& fence, const Braking& braking);

  /// Leaves of the box only what lies inside this one, too; the wind class stays.
  void intersect(const core::Fence& other);

  /// Limits the reference, whose window begins `lead` after now. @param points number of points in x and y that are
  /// filled, beginning with the first; with less than all of them the last decision to stop stays.
  /// @param flown_by the estimate that the law flies by if it is not `estimate`, because its sensors are in doubt. The
  ///   aircraft then follows no reference that brakes, and a stop is a goal far behind it.
  void limit(ref::Window<T>& window, const est::Estimate<T>& estimate, core::TimePoint now, core::Duration lead,
             std::size_t points = ref::kHorizon + 1, const est::Estimate<T>* flown_by = nullptr);
  /// Ends the stops, and forgets their number.
  void reset();

  const Side& x() const { return x_.side; }
  const Side& y() const { return y_.side; }
  /// The deceleration that is left against gusts, force offset and the wind that blows towards the side, at least 0.05
  /// m/s^2. The wind is the one that is estimated at this speed, plus a third of what drag may hide of it.
  T sure_braking_m_s2(T speed_m_s, T wind_m_s2) const;

  /// Of the last limit(): distance from where the aircraft can stop without a reference that brakes (p + e and v + e_v
  /// are then the present state) to the side towards which it flies, without the three sigmas; the smaller of x and y.
  /// Negative: without the reference the aircraft may stop too late.
  T reserve_m() const { return x_.reserve_m < y_.reserve_m ? x_.reserve_m : y_.reserve_m; }
  /// Of the last limit(): how far the estimate is beyond the nearest side, floor or ceiling; negative: inside.
  T outside_m() const { return outside_m_; }
  GeofenceStatus status() const {
    return {
        .reserve_m = static_cast<double>(reserve_m()), .outside_m = static_cast<double>(outside_m_), .stops = stops_};
  }
  const Braking& braking() const { return braking_; }
  /// Of the last limit(): the reference was replaced by a stop.
  bool brakes() const { return x_.stops || y_.stops; }

 private:
  struct Axis {
    Side side{};
    T tilt_sign{1};
    T reserve_m = static_cast<T>(1e6);
    bool stops = false;
    core::TimePoint begin{};  ///< of the stop; its time 0 is one lead later
    ref::TimeOptimal<T> stop{};
  };
  using Points = std::span<ref::AxisReference<T>>;
  static Side side_of(const core::Fence::Side& side);
  static Side narrowed(const Side& side, const core::Fence::Side& other);
  T blowing_m_s2(T speed_m_s, T wind_m_s2) const;
  void update_outside(const Side& side, T position_m);
  T room_m(const Axis& axis, const est::AxisEstimate<T>& estimate, const ref::AxisReference<T>& ahead,
           std::span<const ref::AxisReference<T>> window, T lead_s) const;
  void limit_axis(Points window, Axis& axis, const est::AxisEstimate<T>& estimate, core::TimePoint now, T lead_s,
                  const est::AxisEstimate<T>* flown_by);

  Braking braking_;
  Axis x_, y_;
  Side z_;
  T reaction_s_;
  T wind_m_s2_;    ///< acceleration by a wind of the fence's class
  T unseen_m_s2_;  ///< acceleration by its gusts, and the error of the estimated wind while no pose arrives
  T outside_m_{0};
  std::uint32_t stops_ = 0;
};

extern template class GeofenceLimiter<float>;
extern template class GeofenceLimiter<double>;

}  // namespace m100::ctl
