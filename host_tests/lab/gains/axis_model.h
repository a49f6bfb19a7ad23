// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "firmware/model/vehicle.h"
#include "host_tests/lab/gains/dense.h"

namespace m100::lab::gains {

/// One horizontal axis in continuous time, about hover:
///   p' = v,   v' = tilt_sign g_eff tilt - c v + d,   tilt from the commanded tilt by the attitude model.
/// States x = (p, v, chi), with chi' for an attitude model of second order; x' = f x + g command + gd d. The tilt is
/// chi + z chi', where z is the lead zero [s].
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

/// x(k+1) = a x + b u + bd d, exact if u and d are constant over the step.
struct DiscreteAxis {
  Matrix a;
  Vector b;
  Vector bd;
};

/// The constant part of an axis' quadratic program: the model, the weights and the limits of the input.
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

/// The model of an axis of the vehicle file: x is moved by pitch (sign +), y by roll (sign -). Throws std::domain_error
/// if the axis has no time constant and no natural frequency, or if its lead zero nearly cancels a pole.
ContinuousAxis continuous_axis(const model::Vehicle& vehicle, Axis axis);
/// Discretises exactly for inputs that are constant over the step. @pre f is n x n, n <= mpc::kMaxStates; step_s >= 0.
DiscreteAxis discretise(const ContinuousAxis& axis, Real step_s);
/// The quadratic program of the vehicle's weights and limits, terminal weight from the Riccati equation of (Q, R).
AxisQp axis_qp(const model::Vehicle& vehicle, Axis axis);
inline const model::StickAxis& attitude_of(const model::Vehicle& vehicle, Axis axis) {
  return axis == Axis::kX ? vehicle.pitch : vehicle.roll;
}

}  // namespace m100::lab::gains
