// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/vehicle.h"

namespace m100::ctl {

/// What a vehicle can do about its speed: the one reckoning of the fence, of the level rung and of the limit of speed.
struct Braking {
  /// On each horizontal axis, in still air, while the other axis brakes too.
  double acceleration_m_s2 = 0.0;
  /// The steady push against which it holds its place: at most 4 m/s^2.
  double holds_m_s2 = 0.0;
  /// From the moment in which a stop is wanted until the attitude has turned round.
  double reaction_s = 0.0;
  /// acts_after_s() of the slower axis.
  double acts_s = 0.0;
  /// The drag that the aircraft may have beyond what the vehicle file believes. What is estimated as wind at a speed
  /// has this drag of the speed in it, and loses it as the aircraft slows down.
  double unknown_drag_per_s = 0.0;
  /// The drag by which wind and gusts push.
  double drag_per_s = 0.0;
};

/// Until a command that leaves now has begun to act, and the next one can: transport delay + command period (40 ms).
double acts_after_s(const model::StickAxis& axis);

/// @param slope_limit the largest slope (tangent of tilt) that the control law gives to one horizontal axis while the
///   other one has as much: from the gain tables of this vehicle and from the law's limit of both axes together.
///
/// acceleration = 0.95 g tilt_gain slope_limit: the law takes up its limit by degrees, a twentieth less than it gives.
/// reaction     = transport delay + command period (40 ms) + attitude loop (2 zeta / w, or its time constant) + 20 ms
///                until an estimate has seen what happened; the slower of roll and pitch, at least 0.35 s.
/// A vehicle file that believes less drag than a free rotor aircraft has (published: 0.2 to 0.5 1/s; 0.3) may be wrong
/// by the difference.
Braking braking_of(const model::Vehicle& vehicle, double slope_limit);

}  // namespace m100::ctl
