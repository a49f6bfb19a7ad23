// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/model/axis_step.h"

#include "firmware/core/assert.h"
#include "firmware/core/maths.h"
#include "firmware/model/exponential.h"

namespace m100::model {
namespace {

AxisStep first_order(double time_constant_s, double lead_zero_s, double step_s) {
  const double decay = core::exp(-step_s / time_constant_s);
  AxisStep step;
  step.oo = decay;
  step.o_u = 1.0 - decay;
  step.o_jump = decay * lead_zero_s / time_constant_s;
  step.ro = -decay / time_constant_s;
  step.r_u = -step.o_u / time_constant_s;
  step.r_next = 1.0 / time_constant_s;
  step.r_jump = -step.o_jump / time_constant_s;
  return step;
}

AxisStep second_order(double frequency_rad_s, double damping, double lead_zero_s, double step_s) {
  const double stiffness = frequency_rad_s * frequency_rad_s;
  const SquareMatrix<double, 2> transition =
      exponential<2, double>({0.0, step_s, -stiffness * step_s, -2.0 * damping * frequency_rad_s * step_s});
  AxisStep step{.oo = transition[0], .o_r = transition[1], .ro = transition[2], .rr = transition[3]};
  const double kick = stiffness * lead_zero_s;
  step.o_u = 1.0 - step.oo;  // at rest output = u + m
  step.r_u = -step.ro;
  step.o_jump = step.o_r * kick;
  step.r_jump = step.rr * kick;
  return step;
}

}  // namespace

AxisStep axis_step(const StickAxis& axis, double step_s) {
  M100_ASSERT(step_s >= 0.0);  // a table for a step backwards predicts the past
  if (!axis.is_identified()) {
    return {.o_u = 1.0};
  }
  return axis.is_first_order()
             ? first_order(axis.time_constant_s, axis.lead_zero_s, step_s)
             : second_order(axis.natural_frequency_rad_s, axis.damping_ratio, axis.lead_zero_s, step_s);
}

}  // namespace m100::model
