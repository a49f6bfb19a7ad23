// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/ports/world.h"

#include <algorithm>
#include <cmath>

namespace m100::sim {
namespace {

constexpr std::uint32_t kPoseBaud = 115200;

N1Config n1_config(const Plant& plant, const WorldOptions& options) {
  N1Config config = options.autopilot;
  config.baud = 0;  // the mock line does the pacing
  config.seed = options.seed;
  config.noise = noise_of(plant.sensors);
  config.clock_drift_ppm = plant.link.clock_drift_ppm;
  return config;
}

}  // namespace

N1SensorNoise noise_of(const Sensors& sensors) {
  return {.attitude_rad = sensors.attitude_noise_rad,
          .rate_rad_s = sensors.imu_rate_noise_rad_s,
          .force_m_s2 = sensors.imu_acceleration_noise_m_s2,
          .force_offset_m_s2 = sensors.imu_offset_m_s2,
          .force_vibration_m_s2 = sensors.imu_vibration_m_s2,
          .velocity_zero_share = sensors.velocity_zero_share,
          .height_drift_m = sensors.height_drift_m};
}

World::World(const Plant& plant, const WorldOptions& options)
    : autopilot_line_(clock_, static_cast<std::uint32_t>(std::lround(plant.link.baud)), options.seed),
      pose_line_(clock_, kPoseBaud, options.seed + 1),
      vehicle_(plant, options.seed, options.position_w_m, options.yaw_rad),
      aircraft_(options.body != nullptr ? *options.body : vehicle_),
      autopilot_(autopilot_line_.b(), aircraft_, n1_config(plant, options)),
      pose_sender_(pose_line_.b(), plant, options.seed) {
  hal::LineFaults faults;
  faults.drop_per_byte = plant.link.drop;
  faults.flip_per_bit = plant.link.bit_error_rate;
  faults.chunk = core::Duration(std::llround(plant.link.adapter_s * 1e6));
  autopilot_line_.a_to_b().set_faults(faults);
  autopilot_line_.b_to_a().set_faults(faults);
  autopilot_.set_pilot_sticks({.roll_vrc = 1024.0 + plant.roll.trim_counts,
                               .pitch_vrc = 1024.0 + plant.pitch.trim_counts,
                               .throttle_vrc = 1024.0 + plant.climb.trim_counts,
                               .yaw_vrc = 1024.0 + plant.yaw_rate.trim_counts});
}

void World::advance(core::Duration step) {
  const core::TimePoint end = clock_.now() + step;
  while (clock_.now() < end) {
    const core::TimePoint now = clock_.now();
    const core::TimePoint tick = autopilot_.ticks_next();
    const core::TimePoint pose = pose_sender_.next_event();
    const core::TimePoint next = std::min(end, pose > now ? std::min(tick, pose) : tick);
    clock_.advance(next - now);
    autopilot_.advance(next);
    pose_sender_.step(next, aircraft_, autopilot_.ticked_at());
  }
}

void World::fault(const SensorFault& fault, double size) {
  autopilot_.start_sensor_fault(fault, size);
  PoseFaults faults = pose_source().faults();
  faults.fault = [fault_injector = autopilot_.fault_injector()](PoseSample& sample) { fault_injector->apply(sample); };
  pose_source().set_faults(faults);
}

}  // namespace m100::sim
