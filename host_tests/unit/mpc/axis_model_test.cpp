// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/axis_model.h"

#include <gtest/gtest.h>

#include "firmware/model/axis_step.h"

namespace m100::lab::gains {
namespace {

/// The tilt that belongs to a state of the tables while `command` acts.
double tilt_of(const model::StickAxis& axis, const Vector& state, double command) {
  if (axis.is_first_order()) {
    const Real share = Real(axis.lead_zero_s) / Real(axis.time_constant_s);
    return static_cast<double>((1 - share) * state(2) + share * Real(command));
  }
  return static_cast<double>(state(2) + Real(axis.lead_zero_s) * state(3));
}

// The observer's state holds tilt and tilt rate, the tables' state excludes the lead zero; both must describe the same
// axis. Catches a lead zero, a damping or a step that only one of them has. Tolerance: rounding of a few dozen
// operations.
TEST(AxisModel, TiltsAsTheObserversStepDoes) {
  constexpr double kStep_s = 0.01;
  for (const model::StickAxis& axis :
       {model::StickAxis{.natural_frequency_rad_s = 7.2, .damping_ratio = 0.75},
        model::StickAxis{.natural_frequency_rad_s = 7.2, .damping_ratio = 0.75, .lead_zero_s = 0.11},
        model::StickAxis{.time_constant_s = 0.4}, model::StickAxis{.time_constant_s = 0.4, .lead_zero_s = 0.1}}) {
    model::Vehicle vehicle;
    vehicle.pitch = axis;
    const ContinuousAxis continuous = continuous_axis(vehicle, Axis::kX);
    const DiscreteAxis table = discretise(continuous, Real(kStep_s));
    const model::AxisStep step = model::axis_step(axis, kStep_s);
    Vector state = Vector::Zero(continuous.f.rows());
    double tilt = 0.0, rate = 0.0, before = 0.0;
    for (int k = 0; k < 100; ++k) {
      const double u = k < 40 ? 0.2 : -0.1;
      const double tilt_after = step.oo * tilt + step.o_r * rate + step.o_u * u + step.o_jump * (u - before);
      rate = step.ro * tilt + step.rr * rate + step.r_u * u + step.r_jump * (u - before);
      tilt = tilt_after;
      before = u;
      state = (table.a * state + table.b * Real(u)).eval();
      ASSERT_NEAR(tilt_of(axis, state, u), tilt, 1e-14 * (k + 1))
          << "after " << k + 1 << " steps, lead zero " << axis.lead_zero_s << " s, tau " << axis.time_constant_s
          << " s";
    }
  }
}

}  // namespace
}  // namespace m100::lab::gains
