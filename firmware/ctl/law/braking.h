// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/vehicle.h"
#include "firmware/ref/time_optimal.h"

namespace m100::ctl {

/// The inverse of an attitude loop up to the second derivative: u = t + first t' + second t'' makes it follow t.
struct InverseLags {
  double first_s = 0.0;    ///< T1
  double second_s2 = 0.0;  ///< T2
};
/// (1 + a s + b s^2) / (1 + L s) = 1 + (a - L) s + (b - L (a - L)) s^2 + ..., with a = 2 z / w and b = 1 / w^2, or
/// a = tau and b = 0, and the lead zero L. Zeros for an axis that follows at once.
InverseLags inverse_lags(const model::StickAxis& axis);

/// How a vehicle can brake. Fence, level state, set-point planner, fallback law and wind monitor use this model.
struct Braking {
  /// Deceleration on each horizontal axis, in still air, while the other axis brakes too.
  double acceleration_m_s2 = 0.0;
  /// The acceleration of the largest tilt of both axes together.
  double tilted_m_s2 = 0.0;
  /// The steady disturbance against which the aircraft can hold its position: at most 4 m/s^2.
  double max_disturbance_m_s2 = 0.0;
  /// Time from the decision to stop until the attitude is reversed and the estimate shows it; at least 0.35 s.
  double reaction_s = 0.0;
  /// By a steady tilt t and its rate t' the speed still changes by g (lag t + lag2 t') after a command to level.
  double lag_s = 0.0;
  double lag2_s2 = 0.0;
  /// effective_delay_s() of the slower axis.
  double acts_s = 0.0;
  /// Drag that the aircraft may have in addition to that of the vehicle file. The wind that is estimated at a speed
  /// includes this drag, which disappears as the aircraft slows down.
  double unknown_drag_per_s = 0.0;
  /// The drag by which wind and gusts accelerate the aircraft: that of the vehicle file, but at least 0.3 1/s.
  double drag_per_s = 0.0;
};

/// Time from a command to the earliest effect of the command after it: transport delay + command period (40 ms).
double effective_delay_s(const model::StickAxis& axis);

/// @param slope_limit the largest slope (tangent of tilt) that the control law gives to one horizontal axis while the
///   other one has as much: from the gain tables of this vehicle and from the law's limit of both axes together.
///
/// acceleration = 0.95 g tilt_gain slope_limit: the law approaches its limit gradually, hence a twentieth less.
/// reaction     = transport delay + command period (40 ms) + attitude loop (2 zeta / w, or its time constant) + 20 ms
///                until the estimate shows the effect; the slower of roll and pitch, at least 0.35 s.
/// tilted       = g tilt_gain sqrt(2) slope_limit
/// lag, lag2    = transport delay + T1, and T2, of inverse_lags(); the slower of roll and pitch, the lag at least 0.1 s
/// unknown drag = 0.3 1/s (published for free rotor aircraft: 0.2 to 0.5) less the vehicle file's drag, at least 0.
Braking braking_of(const model::Vehicle& vehicle, double slope_limit);

/// Limits of a planned motion of one axis whose tilt can accelerate it by tilted_m_s2. Jerk: the tilt is reversed in
/// Braking::reaction_s less Braking::acts_s. The final release is slower, so that the feedback can correct an error: it
/// takes half of the tilt back in one Braking::reaction_s. Acceleration: `authority` times that of the tilt, plus or
/// minus the disturbance, but at least a quarter of it.
/// @param authority share of the tilt that the aircraft reaches
template <typename T>
ref::AxisLimits<T> motion_limits(const Braking& braking, T tilted_m_s2, T authority, T disturbance_m_s2) {
  constexpr T kMaxSpeed_m_s = T(17);  // of the aircraft, by its maker
  const auto at_least_a_quarter = [=](T acceleration_m_s2) {
    return acceleration_m_s2 > T(0.25) * tilted_m_s2 ? acceleration_m_s2 : T(0.25) * tilted_m_s2;
  };
  const T reached_m_s2 = authority * tilted_m_s2;
  return {.speed_m_s = kMaxSpeed_m_s,
          .up_m_s2 = at_least_a_quarter(reached_m_s2 + disturbance_m_s2),
          .down_m_s2 = at_least_a_quarter(reached_m_s2 - disturbance_m_s2),
          .jerk_m_s3 = T(2) * tilted_m_s2 / static_cast<T>(braking.reaction_s - braking.acts_s),
          .release_m_s3 = T(0.5) * tilted_m_s2 / static_cast<T>(braking.reaction_s)};
}

}  // namespace m100::ctl
