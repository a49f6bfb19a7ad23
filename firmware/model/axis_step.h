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
/// u is the command that acts during the step, a transport delay after it was sent; m is an offset of the input.
/// Second order: output'' = w^2 (u + L u' + m - output) - 2 z w output'; a jump of u adds w^2 L times it to the rate.
/// First order : output' = (u + L u' + m - output) / tau; the rate is then no state, but this right-hand side at the
/// end of the step, with the command of the next step.
struct AxisStep {
  double oo = 0.0, o_r = 0.0, o_u = 0.0, o_jump = 0.0;
  double ro = 0.0, rr = 0.0, r_u = 0.0, r_next = 0.0, r_jump = 0.0;
};

/// Discretises the linear part of an axis: time constant, or natural frequency and damping, and lead zero L. The caller
/// applies the stick law, the limits and the transport delay. An axis without dynamics follows at once. Requires w^2
/// step + 2 z w step of at most 2^kMaxHalvings (exponential.h). On the target before the first tick only.
AxisStep axis_step(const StickAxis& axis, double step_s);

}  // namespace m100::model
