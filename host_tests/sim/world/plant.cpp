// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/plant.h"

#include <cmath>

#include "firmware/model/paper.h"

namespace m100::sim {

Plant measured_plant() {
  namespace paper = model::paper;
  Plant plant;
  // pitch_roll.csv, 12..55.5 s: second order, delay, dead zone and trim fitted by the simulation error of 2.5 s blocks
  // (residual 0.0071 rad roll, 0.0059 rad pitch). The autopilot of that flight had re-centred its trims, so the paper's
  // trims are used instead.
  plant.roll = {.scale_per_count = 9.23e-4,
                .natural_frequency_rad_s = 9.26,
                .damping_ratio = 0.703,
                .transport_delay_s = 0.0104,
                .dead_zone_counts = 14.05,
                .trim_counts = paper::kRollBalance_vrc - paper::kNeutral_vrc};
  plant.pitch = {.scale_per_count = 9.22e-4,
                 .natural_frequency_rad_s = 8.05,
                 .damping_ratio = 0.612,
                 .dead_zone_counts = 18.45,
                 .trim_counts = paper::kPitchBalance_vrc - paper::kNeutral_vrc};
  // yaw.csv, 10..51 s, every second block of 6 s (residual 0.036 rad/s). A dead zone of 65 counts leaves 0.039 rad/s.
  plant.yaw_rate.scale_per_count = 3.101e-3;
  plant.yaw_rate.time_constant_s = 0.2152;
  plant.yaw_rate.stick_exponent = 1.45;
  // height.csv, 4.5..64.5 s, fitted likewise (residual 0.076 m/s). The authors' program has a dead zone of 39.6 counts.
  // The flight does not separate it from a stick curve with an asymmetry, which the default vehicle file has.
  plant.climb.scale_per_count = 3.579e-3;
  plant.climb.natural_frequency_rad_s = 6.108;
  plant.climb.damping_ratio = 0.897;
  plant.climb.dead_zone_counts = 40.65;
  return plant;
}

Plant changed(Plant plant) {
  const Change change = plant.change;
  for (const auto& step : change.steps) {
    step(plant);
  }
  return plant;
}

Plant with_fan(Plant plant) {
  constexpr double kSpeed_m_s = 0.5 * (model::paper::kFanWindLow_m_s + model::paper::kFanWindHigh_m_s);
  constexpr double kJetTurbulence = 0.15;  // share of the speed, for a free jet several diameters from its fan
  // Hover yaw RMS grows from 1.087 to 1.844 deg in the fan: sqrt(1.844^2 - 1.087^2) / 1.087 = 1.37 of the calm one.
  constexpr double kHeadingDisturbance = 1.37;
  // The steady tilts of the same table (see Air) give the direction: 0.175 deg of pitch, 0.930 deg of roll.
  const double along_x = 0.175 / std::hypot(0.175, 0.930);
  const double along_y = 0.930 / std::hypot(0.175, 0.930);
  plant.air.wind_m_s += kSpeed_m_s * core::Vector<double, 3>(along_x, along_y, 0.0);
  plant.air.turbulence_m_s = std::hypot(plant.air.turbulence_m_s, kJetTurbulence * kSpeed_m_s);
  plant.air.yaw_rate_disturbance_rad_s *= std::hypot(1.0, kHeadingDisturbance);
  plant.air.turn_disturbance_rad_s *= std::hypot(1.0, kHeadingDisturbance);
  return plant;
}

}  // namespace m100::sim
