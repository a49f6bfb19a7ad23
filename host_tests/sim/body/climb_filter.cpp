// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/climb_filter.h"

namespace m100::sim {

void ClimbFilter::update(double acceleration_m_s2, double barometer_m, double step_s) {
  const double error_m = barometer_m - height_m_;
  const double pole = 1.0 / time_constant_s_;
  const double acceleration = acceleration_m_s2 + bias_m_s2_ + 3.0 * pole * pole * error_m;
  height_m_ += step_s * (climb_m_s_ + 0.5 * step_s * acceleration + 3.0 * pole * error_m);
  climb_m_s_ += step_s * acceleration;
  bias_m_s2_ += step_s * pole * pole * pole * error_m;
}

}  // namespace m100::sim
