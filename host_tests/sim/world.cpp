// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world.h"

#include <cmath>

#include "protocol/pose_message.h"

namespace m100::sim {
namespace {

constexpr std::uint32_t kPoseBaud = 115200;

N1Config n1_config(const Plant& plant, const WorldOptions& options) {
  N1Config config = options.autopilot;
  config.baud = 0;  // the mock line keeps the time
  config.seed = options.seed;
  config.noise.attitude_rad = plant.sensors.attitude_noise_rad;
  config.noise.rate_rad_s = plant.sensors.imu_rate_noise_rad_s;
  config.noise.force_m_s2 = plant.sensors.imu_acceleration_noise_m_s2;
  return config;
}

}  // namespace

World::World(const Plant& plant, const WorldOptions& options)
    : autopilot_line_(clock_, static_cast<std::uint32_t>(std::lround(plant.link.baud)), options.seed),
      pose_line_(clock_, kPoseBaud, options.seed + 1),
      vehicle_(plant, options.seed, options.position_w_m, options.yaw_rad),
      autopilot_(autopilot_line_.b(), vehicle_, n1_config(plant, options)),
      pose_source_(plant.sensors, options.seed) {
  hal::LineFaults faults;
  faults.drop_per_byte = plant.link.drop;
  faults.flip_per_bit = plant.link.bit_error_rate;
  autopilot_line_.a_to_b().set_faults(faults);
  autopilot_line_.b_to_a().set_faults(faults);
  autopilot_.set_pilot_sticks({.roll_vrc = 1024.0 + plant.roll.trim_counts,
                               .pitch_vrc = 1024.0 + plant.pitch.trim_counts,
                               .throttle_vrc = 1024.0 + plant.climb.trim_counts,
                               .yaw_vrc = 1024.0 + plant.yaw_rate.trim_counts});
}

void World::send_poses() {
  const core::TimePoint now = clock_.now();
  while (const auto sample = pose_source_.step(now, vehicle_.state(), vehicle_.attitude().yaw_rad)) {
    const double half_yaw = 0.5 * sample->yaw_rad;
    protocol::PoseMessage message;
    message.sequence = ++pose_sequence_;
    message.age_us = static_cast<std::uint32_t>((now - sample->captured).count());
    message.position_w_m = {static_cast<float>(sample->position_w_m.x()), static_cast<float>(sample->position_w_m.y()),
                            static_cast<float>(sample->position_w_m.z())};
    message.rotation_wb = {static_cast<float>(std::cos(half_yaw)), 0.0F, 0.0F, static_cast<float>(std::sin(half_yaw))};
    static_cast<void>(pose_line_.b().write(protocol::encode(message)));  // a full line loses the pose
  }
}

void World::advance(core::Duration step) {
  const core::TimePoint end = clock_.now() + step;
  while (clock_.now() < end) {
    const core::Duration rest = end - clock_.now();
    clock_.advance(rest < N1Autopilot::kTick ? rest : N1Autopilot::kTick);
    autopilot_.advance(clock_.now());
    send_poses();
  }
}

}  // namespace m100::sim
