// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::est {

/// Dynamics of an output (tilt, or climb speed) that follows a command, exactly discretised over one step for commands
/// that are constant between two steps:
///
///   output+ = oo output + or rate + o_u (u + m)      + o_jump (u - u_before)
///   rate+   = ro output + rr rate + r_u (u + m) + r_next (u_next + m) + r_jump (u - u_before)
///
/// Second order: output'' = w^2 (u + L u' + m - output) - 2 z w output'; a step of u kicks the rate by w^2 L.
/// First order : output' = (u + L u' + m - output) / tau; the rate is no state of its own then, it is that right side
/// taken at the end of the step with the command of the next one.
struct AttitudeStep {
  double oo = 0.0, o_r = 0.0, o_u = 0.0, o_jump = 0.0;
  double ro = 0.0, rr = 0.0, r_u = 0.0, r_next = 0.0, r_jump = 0.0;
};

/// One axis in the words of the vehicle file.
struct ResponseModel {
  double time_constant_s = 0.0;  ///< above 0: first order
  double natural_frequency_rad_s = 0.0;
  double damping_ratio = 0.0;
  double lead_zero_s = 0.0;
};

/// Neither a time constant nor a natural frequency: an output that follows at once is of first order with this tau.
inline constexpr double kFastestTimeConstant_s = 0.01;

/// Valid for natural frequencies up to 50 rad/s, damping up to 4, steps up to 20 ms.
AttitudeStep discretise(const ResponseModel& model, double step_s);

}  // namespace m100::est
