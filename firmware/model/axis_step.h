// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/stick_axis.h"

namespace m100::model {

/// How the output of a stick axis (an angle, a rate or a climb speed) follows its command, exactly discretised over one
/// step for a command that is constant between two steps:
///
///   output+ = oo output + o_r rate + o_u (u + m)                   + o_jump (u - u_before)
///   rate+   = ro output + rr rate  + r_u (u + m) + r_next (u_next + m) + r_jump (u - u_before)
///
/// u is the command that acts during the step, a transport delay after it was given; m is an offset of the input.
/// Second order: output'' = w^2 (u + L u' + m - output) - 2 z w output'; a jump of u kicks the rate by w^2 L.
/// First order : output' = (u + L u' + m - output) / tau; the rate is no state of its own then, it is that right side
/// taken at the end of the step with the command of the next one.
struct AxisStep {
  double oo = 0.0, o_r = 0.0, o_u = 0.0, o_jump = 0.0;
  double ro = 0.0, rr = 0.0, r_u = 0.0, r_next = 0.0, r_jump = 0.0;
};

/// Discretises the linear part of an axis: time constant, or natural frequency and damping, and lead zero L. The law of
/// the stick, the limits and the delay of whole steps are the caller's. Observer, residual monitor, identification and
/// the excitation forecast take their numbers from here; the tables of the MPC, whose state goes on to the position,
/// share exponential().
/// An axis without dynamics follows at once. Requires w^2 step + 2 z w step of at most 2^kMostHalvings (exponential.h).
/// Before the first tick only.
AxisStep axis_step(const StickAxis& axis, double step_s);

}  // namespace m100::model
