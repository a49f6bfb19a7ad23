// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/plant.h"

#include <cmath>

#include "firmware/model/paper.h"

namespace m100::sim {

Plant measured_plant() {
  namespace paper = model::paper;
  Plant plant;
  plant.roll.scale_rad_per_count = 9.31e-4;
  plant.roll.natural_frequency_rad_s = 9.0;
  plant.roll.damping_ratio = 0.68;
  plant.roll.transport_delay_s = 0.03;
  plant.roll.dead_zone_counts = 17.5;
  plant.roll.trim_counts = paper::kRollBalance_vrc - paper::kNeutral_vrc;
  plant.roll.saturation_rad = 0.6;
  plant.pitch = plant.roll;
  plant.pitch.scale_rad_per_count = 9.1e-4;
  plant.pitch.trim_counts = paper::kPitchBalance_vrc - paper::kNeutral_vrc;
  plant.yaw_rate.scale_per_count = paper::kScaleYawRate_rad_s_per_count.experiment * paper::kYawRateFirst.gain;
  plant.yaw_rate.time_constant_s = paper::kYawRateFirst.time_constant_s;
  plant.yaw_rate.dead_zone_counts = paper::kYawRateDeadZone_vrc;
  plant.climb.scale_per_count = paper::kScaleClimb_m_s_per_count.experiment * paper::kClimbSecond.gain;
  plant.climb.natural_frequency_rad_s = paper::kClimbSecond.natural_frequency_rad_s;
  plant.climb.damping_ratio = paper::kClimbSecond.damping_ratio;
  plant.climb.dead_zone_counts = paper::kClimbDeadZone_vrc;
  return plant;
}

Plant with_fan(Plant plant) {
  constexpr double kSpeed_m_s = 0.5 * (model::paper::kFanWindLow_m_s + model::paper::kFanWindHigh_m_s);
  constexpr double kJetTurbulence = 0.15;  // of the speed, a free jet several diameters from its fan
  // Hover yaw RMS grows from 1.087 to 1.844 deg in the fan: sqrt(1.844^2 - 1.087^2) / 1.087 = 1.37 of the calm one.
  constexpr double kHeadingDisturbance = 1.37;
  plant.air.wind_m_s += core::Vector<double, 3>(kSpeed_m_s / std::sqrt(2.0), kSpeed_m_s / std::sqrt(2.0), 0.0);
  plant.air.turbulence_m_s = std::hypot(plant.air.turbulence_m_s, kJetTurbulence * kSpeed_m_s);
  plant.air.yaw_rate_disturbance_rad_s *= std::hypot(1.0, kHeadingDisturbance);
  return plant;
}

}  // namespace m100::sim
