// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "firmware/model/vehicle.h"
#include "host_tests/lab/gains/dense.h"

namespace m100::lab::gains {

/// One horizontal axis in continuous time, about hover:
///   p' = v,   v' = tilt_sign g_eff tilt - c v + d,   tilt from the commanded tilt by the attitude model.
/// States x = (p, v, chi [, chi']), x' = f x + g command + gd d; tilt = chi + z chi', z the lead zero (0: tilt = chi).
struct ContinuousAxis {
  Matrix f;   ///< n x n
  Vector g;   ///< command
  Vector gd;  ///< disturbance
  std::size_t states = 3;
  Real tilt_sign = 1;
  Real acceleration_per_tilt = 0;
  Real drag_per_s = 0;
  Real input_gain = 1;
};

/// x(k+1) = a x + b u + bd d: exact for an input held over the step.
struct DiscreteAxis {
  Matrix a;
  Vector b;
  Vector bd;
};

/// The part of an axis' quadratic program that is the same in every tick, as a model record of the benchmark holds it.
struct AxisQp {
  DiscreteAxis step;  ///< over the prediction step
  Vector q;           ///< diagonal
  Real r = 0;
  Real rd = 0;
  Matrix p;  ///< terminal weight
  Real u_min = 0;
  Real u_max = 0;
  Real input_gain = 1;
  Real tilt_sign = 1;
  Real acceleration_per_tilt = 0;
  Real drag_per_s = 0;
};

enum class Axis { kX, kY };

/// The axis of the vehicle file: x by pitch (+), y by roll (-). Throws std::domain_error: it has no dynamics, or a lead
/// zero cancels a pole.
ContinuousAxis continuous_axis(const model::Vehicle& vehicle, Axis axis);
/// Exact for held inputs. @pre f is n x n with n at most mpc::kMaxStates, g and gd have n rows, step_s >= 0 [s].
DiscreteAxis discretise(const ContinuousAxis& axis, Real step_s);
/// The quadratic program of the vehicle's weights and limits, terminal weight from the Riccati equation of (Q, R).
AxisQp axis_qp(const model::Vehicle& vehicle, Axis axis);
inline const model::StickAxis& attitude_of(const model::Vehicle& vehicle, Axis axis) {
  return axis == Axis::kX ? vehicle.pitch : vehicle.roll;
}

}  // namespace m100::lab::gains
