// SPDX-License-Identifier: BSD-3-Clause
// Checks that fit, simulation and identification know the added effect. Compiled in the copy of new_effect.py.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "firmware/model/axis_effects.h"
#include "firmware/sysid/axis_dynamics.h"
#include "host_tests/lab/identify/model/axis/axis_structure.h"
#include "host_tests/sim/world/axis_motion.h"

using namespace m100;  // Deviation: a test program of one page.

int main() {
  const model::AxisEffect* effect = model::axis_effect("rise_limit");
  if (effect == nullptr) {
    std::puts("the table of effects does not have the effect");
    return 2;
  }
  model::StickAxis axis{.scale_per_count = 1e-3, .natural_frequency_rad_s = 9.0, .damping_ratio = 0.7};
  axis.*effect->numbers[0].member = 0.5;
  sysid::AxisDynamics<double> fitted(axis, 0.01);
  fitted.start(0.0, 0.0);
  sim::AxisMotion simulated(axis, 0.0);
  simulated.set_direct(0.4);
  for (const double command : {0.4, -0.4}) {
    simulated.set_direct(command);
    double fastest_fitted = 0.0;
    double fastest_simulated = 0.0;
    for (int k = 0; k < 100; ++k) {
      const double before = fitted.value();
      const double was = simulated.output();
      fastest_fitted = std::max(fastest_fitted, std::abs(fitted.step(command) - before) / 0.01);
      simulated.advance(0.01, 0.0, 1.0);
      fastest_simulated = std::max(fastest_simulated, std::abs(simulated.output() - was) / 0.01);
    }
    for (const double fastest : {fastest_fitted, fastest_simulated}) {
      if (command > 0.0 ? fastest > 0.5 + 1e-9 : fastest < 1.0) {
        std::printf("towards %g the fit is at most %g, the simulation %g per second fast\n", command, fastest_fitted,
                    fastest_simulated);
        return 2;
      }
    }
  }
  const auto edits = lab::identify::axis_edits({"second_order"}, false);
  if (std::none_of(edits.begin(), edits.end(), [](const auto& one) { return one.name == "rise_limit"; })) {
    std::puts("identification does not try the effect");
    return 2;
  }
  return 0;
}
