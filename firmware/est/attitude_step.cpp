// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/attitude_step.h"

#include "firmware/core/maths.h"

namespace m100::est {
namespace {

AttitudeStep first_order(double time_constant_s, double lead_zero_s, double step_s) {
  const double decay = core::exp(-step_s / time_constant_s);
  AttitudeStep step;
  step.oo = decay;
  step.o_u = 1.0 - decay;
  step.o_jump = decay * lead_zero_s / time_constant_s;
  step.ro = -decay / time_constant_s;
  step.r_u = -step.o_u / time_constant_s;
  step.r_next = 1.0 / time_constant_s;
  step.r_jump = -step.o_jump / time_constant_s;
  return step;
}

// The Taylor series of exp(M h) for M = [0 1; -w^2 -2zw]: the terms fall below the last bit within 40 for |M h| <= 5.
AttitudeStep second_order(double frequency_rad_s, double damping, double lead_zero_s, double step_s) {
  const double m10 = -frequency_rad_s * frequency_rad_s * step_s;
  const double m11 = -2.0 * damping * frequency_rad_s * step_s;
  double t00 = 1.0, t01 = 0.0, t10 = 0.0, t11 = 1.0;
  AttitudeStep step{.oo = 1.0, .rr = 1.0};
  for (int term = 1; term <= 40; ++term) {
    const double n = 1.0 / term;
    const double u00 = t01 * m10, u01 = t00 * step_s + t01 * m11;
    const double u10 = t11 * m10, u11 = t10 * step_s + t11 * m11;
    t00 = u00 * n;
    t01 = u01 * n;
    t10 = u10 * n;
    t11 = u11 * n;
    step.oo += t00;
    step.o_r += t01;
    step.ro += t10;
    step.rr += t11;
  }
  const double kick = frequency_rad_s * frequency_rad_s * lead_zero_s;
  step.o_u = 1.0 - step.oo;  // at rest output = u + m
  step.r_u = -step.ro;
  step.o_jump = step.o_r * kick;
  step.r_jump = step.rr * kick;
  return step;
}

}  // namespace

AttitudeStep discretise(const ResponseModel& model, double step_s) {
  if (model.time_constant_s > 0.0 || !(model.natural_frequency_rad_s > 0.0)) {
    const double tau_s =
        model.time_constant_s > kFastestTimeConstant_s ? model.time_constant_s : kFastestTimeConstant_s;
    return first_order(tau_s, model.lead_zero_s, step_s);
  }
  return second_order(model.natural_frequency_rad_s, model.damping_ratio, model.lead_zero_s, step_s);
}

}  // namespace m100::est
