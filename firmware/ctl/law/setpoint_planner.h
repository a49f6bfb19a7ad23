// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "firmware/core/time.h"
#include "firmware/ctl/law/braking.h"
#include "firmware/ctl/law/geofence_limiter.h"
#include "firmware/est/estimate.h"
#include "firmware/mpc/gain_table.h"
#include "firmware/ref/time_optimal.h"
#include "firmware/ref/window.h"

namespace m100::ctl {

/// Replaces the jump to a new set point by the fastest motion that the aircraft can make (ref/time_optimal.h). Windows
/// that are not constant stay as they are.
///
/// Limits of the motion per axis. Acceleration: the tilt limit of the gain table, or the axis' part of the law's
/// combined limit if that is less, plus or minus the disturbance. Braking uses kBrakingShare of it; the rest is for the
/// feedback. Jerk and release: motion_limits().
///
/// A goal outside the fence is moved to the nearest place inside. Before a side the braking c is lower. An aircraft
/// that accelerates one reaction time t too long, to v + a t, and has only the braking s of which the fence is sure,
/// then passes the goal by at most the room r to the last place that may be a goal. With the way L, the top speed v,
/// v^2 / 2 = L / (1 / a + 1 / c), and b = s (v / (v + a t))^2:
///   c = (L + r) / (L / b - r / a)
///
/// A motion is planned again from the measured state if the aircraft is more than kMaxError_m away from it, and from
/// its own state if the disturbance has changed by more than kMaxChange_m_s2. This happens at most kMaxReplans times
/// for one goal. At most one axis is planned in a tick. T is float or double.
template <typename T>
class SetpointPlanner {
 public:
  static constexpr double kBrakingShare = 0.95;
  static constexpr double kMinAuthority = 0.8;  ///< share of the identified gain: the least in the box of the margins
  static constexpr double kMaxError_m = 0.3;    ///< twice the shipped vehicle's largest deviation in a motion of 6 m
  static constexpr double kMaxChange_m_s2 = 0.5;
  static constexpr unsigned kMaxReplans = 10;

  SetpointPlanner(const Braking& braking, const mpc::GainTables<T>& tables, T combined_slope);

  /// Once per tick while the law flies. @param lead from now to the first point of the window. @param points how many
  /// points of the window to fill, beginning with the first.
  void update(ref::Window<T>& window, const est::Estimate<T>& estimate, const GeofenceLimiter<T>& fence,
              core::TimePoint now, core::Duration lead, std::size_t points);
  /// Forgets the goal: the next set point is planned from the measured state.
  void reset() { follows_ = false; }

 private:
  struct Axis {
    ref::TimeOptimal<T> motion{};
    core::TimePoint begin{};  ///< the motion's time 0 is one lead later
    T goal_m{0};
    T max_slope{0};       ///< of the table
    T per_slope_m_s2{0};  ///< acceleration per slope, with the axis' sign
    T slope{0};           ///< largest slope for the motion to the present goal
    T at_rest_m_s2{0};    ///< disturbance when the goal was set
    T planned_m_s2{0};    ///< disturbance that the motion was planned with
    T authority{1};       ///< share of the commanded slope that the aircraft was measured to reach
    unsigned replans = 0;
    bool is_due = false;  ///< a motion to goal_m has to be planned
    bool is_off = false;  ///< the aircraft is not where the motion is: plan from the estimate
  };
  static Axis make_axis(const mpc::GainTable<T>& table);
  T measured_m_s2(const Axis& axis, const est::AxisEstimate<T>& estimate) const;
  ref::AxisReference<T> measured(const Axis& axis, const est::AxisEstimate<T>& estimate, T ahead_s) const;
  ref::AxisLimits<T> limits(const Axis& axis, const est::AxisEstimate<T>& estimate, const ref::AxisReference<T>& from,
                            const GeofenceLimiter<T>& fence) const;
  void set_goals(T x_m, T y_m, const est::Estimate<T>& estimate);
  void set_goal(Axis& axis, const est::AxisEstimate<T>& estimate, T goal_m, T share);
  void check(Axis& axis, const est::AxisEstimate<T>& estimate, T time_s, T lead_s);
  void learn_authority(Axis& axis, const est::AxisEstimate<T>& estimate, T time_s) const;
  bool plan_if_due(Axis& axis, const est::AxisEstimate<T>& estimate, const GeofenceLimiter<T>& fence,
                   core::TimePoint now, T lead_s);

  Axis x_, y_;
  T combined_slope_;
  Braking braking_;
  T reaction_s_;
  bool follows_ = false;  ///< the axes hold a goal
};

extern template class SetpointPlanner<float>;
extern template class SetpointPlanner<double>;

}  // namespace m100::ctl
