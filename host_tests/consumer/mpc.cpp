// SPDX-License-Identifier: BSD-3-Clause
// Uses the MPC of one axis alone: a step of 2 m over 10 s, with the project's table and a model of the axis.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "firmware/model/vehicle.h"
#include "firmware/mpc/generated/gain_table.h"
#include "firmware/mpc/horizontal_mpc.h"

int main() {
  namespace mpc = m100::mpc;
  mpc::HorizontalMpc<double> law(mpc::generated::kX<double>);
  const m100::model::StickAxis& pitch = mpc::generated::kVehicle.pitch;
  const double w = pitch.natural_frequency_rad_s, zeta = pitch.damping_ratio;
  double x = 0.0, v = 0.0, tilt = 0.0, rate = 0.0, last = 0.0, farthest = 0.0;
  for (int tick = 0; tick < 1000; ++tick) {
    mpc::Problem<double> problem;
    problem.state = {x, v, tilt, rate};
    problem.previous_input_slope = last;
    problem.position_ref_m.fill(2.0);
    problem.constant_reference = true;
    last = law.solve(problem).input_slope[0];
    for (int step = 0; step < 10; ++step) {  // 1 ms each
      rate += 1e-3 * (w * w * (last - tilt) - 2.0 * zeta * w * rate);
      tilt += 1e-3 * rate;
      v += 1e-3 * m100::model::kGravity_m_s2 * tilt;
      x += 1e-3 * v;
    }
    farthest = std::max(farthest, x);
  }
  std::printf("after 10 s: %.3f m, %.3f m/s; overshoot %.0f mm\n", x, v, 1000.0 * (farthest - 2.0));
  // A jump that nobody plans (ref/time_optimal.h) overshoots by 0.43 m with the default's robust design.
  return std::abs(x - 2.0) < 0.01 && farthest < 2.5 ? 0 : 1;
}
