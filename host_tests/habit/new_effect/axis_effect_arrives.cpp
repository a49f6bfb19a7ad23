// SPDX-License-Identifier: BSD-3-Clause
// Checks that simulation, files and identification know the added effect. Compiled in the copy of new_effect.py.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "firmware/companion/files/vehicle_keys.h"
#include "firmware/model/axis_effects.h"
#include "host_tests/lab/identify/model/axis/axis_structure.h"

using namespace m100;  // Deviation: a test program of one page.

int main() {
  const model::AxisEffect* effect = model::axis_effect("motion_gain");
  if (effect == nullptr) {
    std::puts("the table of effects does not have the effect");
    return 2;
  }
  model::StickAxis axis{.scale_per_count = 1e-3};
  axis.*effect->numbers[0].member = 1.5;
  model::StickLaw<double> law(axis, 0.01);
  law.command(0.0, 0.0, 0.0);
  const double rising = law.command(100.0, 0.0, 0.0);
  law.command(200.0, 0.0, 0.0);
  const double falling = law.command(100.0, 0.0, 0.0);
  if (std::abs(rising - 0.12) > 1e-12 || std::abs(falling - 0.08) > 1e-12) {
    std::printf("the law gives %g rising and %g falling\n", rising, falling);
    return 2;
  }
  for (const model::AxisUnit unit :
       {model::AxisUnit::kTilt_rad, model::AxisUnit::kYawRate_rad_s, model::AxisUnit::kClimb_m_s}) {
    const auto keys = companion::axis_keys(unit);
    if (keys.back().key != "motion_gain_ratio" || !keys.back().only_if_set) {
      std::puts("the effect's key is not the last one of the files");
      return 2;
    }
  }
  const auto edits = lab::identify::axis_edits({"second_order"}, false);
  if (std::none_of(edits.begin(), edits.end(), [](const auto& one) { return one.name == "motion_gain"; })) {
    std::puts("identification does not try the effect");
    return 2;
  }
  return 0;
}
