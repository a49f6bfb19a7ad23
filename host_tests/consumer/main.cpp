// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "firmware/core/frames.h"
#include "firmware/model/default_vehicle.h"

// Turns a level vehicle that points west: fails to link, or answers wrongly, when the package is incomplete.
int main() {
  const m100::core::Euler<double> west{.yaw_rad = m100::core::kPi / 2};
  const double yaw_rad = m100::core::euler_of(m100::core::quaternion_of(west)).yaw_rad;
  constexpr m100::model::Vehicle kPaper = m100::model::paper_vehicle();
  std::printf("yaw %.6f rad, roll %.3f rad/s\n", yaw_rad, kPaper.roll.natural_frequency_rad_s);
  return yaw_rad > 1.57 && yaw_rad < 1.571 ? 0 : 1;
}
