// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "firmware/core/time.h"
#include "firmware/ctl/law/braking.h"
#include "firmware/est/estimate.h"
#include "firmware/mpc/gain_table.h"
#include "firmware/ref/time_optimal.h"
#include "firmware/ref/window.h"

namespace m100::ctl {

/// Replaces the jump to a new set point by the fastest motion that the aircraft can make (ref/time_optimal.h), so that
/// the law sees the braking beyond its horizon. Windows that are not constant stay as they are.
///
/// Limits per axis. Acceleration: by the tilt of the gain table, or by the axis' part (a quarter at least) of the law's
/// limit of both axes in the direction of the goal if that is less; plus or minus the disturbance, but at least a
/// quarter of the tilt's. Braking uses kBrakingShare of it and leaves the rest to the feedback. Jerk: the tilt is
/// reversed in Braking::reaction_s less Braking::acts_s; the final release is slower, see kRelease.
///
/// The motion of an axis is planned again at most kMaxReplans times for one goal: from the measured state, when the
/// aircraft has left the motion by more than kMaxError_m (if it accelerates less than planned, the plan's tilt is
/// scaled down, too, not below kMinAuthority); or from the motion's own state, when the disturbance has changed by more
/// than kMaxChange_m_s2 since it was planned: a wind looks weaker the faster one flies with it. All limits use the
/// present disturbance, moved a third of the way back to its value when the goal was set: the mean during the braking.
///
/// One axis is planned a tick. After both motions' end the window is the set point itself again. T is float or double.
template <typename T>
class SetpointPlanner {
 public:
  static constexpr double kBrakingShare = 0.95;
  /// Share of the tilt that the final release removes in Braking::reaction_s: the feedback needs one reaction time to
  /// see an error of the release, and another one to correct it.
  static constexpr double kRelease = 0.5;
  static constexpr double kMinAuthority = 0.8;  ///< share of the identified gain: the least in the certificate's box
  static constexpr double kMaxError_m = 0.3;    ///< twice the shipped vehicle's largest deviation in a motion of 6 m
  static constexpr double kMaxChange_m_s2 = 0.5;
  static constexpr unsigned kMaxReplans = 10;

  SetpointPlanner(const Braking& braking, const mpc::GainTables<T>& tables, T combined_slope);

  /// Once per tick while the law flies. @param lead from now to the first point of the window. @param points how many
  /// points of the window to fill, beginning with the first.
  void update(ref::Window<T>& window, const est::Estimate<T>& estimate, core::TimePoint now, core::Duration lead,
              std::size_t points);
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
  ref::AxisLimits<T> limits(const Axis& axis, const est::AxisEstimate<T>& estimate) const;
  void set_goals(T x_m, T y_m, const est::Estimate<T>& estimate);
  void set_goal(Axis& axis, const est::AxisEstimate<T>& estimate, T goal_m, T share);
  void check(Axis& axis, const est::AxisEstimate<T>& estimate, T time_s, T lead_s);
  void learn_authority(Axis& axis, const est::AxisEstimate<T>& estimate, T time_s) const;
  bool plan_if_due(Axis& axis, const est::AxisEstimate<T>& estimate, core::TimePoint now, T lead_s);

  Axis x_, y_;
  T combined_slope_;
  T reaction_s_;
  T reversal_s_;          ///< of the attitude, once the command acts
  bool follows_ = false;  ///< the axes hold a goal
};

extern template class SetpointPlanner<float>;
extern template class SetpointPlanner<double>;

}  // namespace m100::ctl
