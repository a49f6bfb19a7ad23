// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/sensor_faults/sensor_fault_injector.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/core/frames.h"
#include "firmware/core/maths.h"

namespace m100::sim {
namespace {

using Place = core::Vector<double, 3>;
using Poses = SensorFaultState<PoseSample>;
using protocol::Telemetry;
using Packages = SensorFaultState<Telemetry>;

constexpr double kTickHz = 400.0;

// The pose.

/// Transforms the displacement from the first sample.
void about(PoseSample& sample, const Poses& memory, double xx, double xy, double yx, double yy) {
  const Place d = sample.position_w_m - memory.first->position_w_m;
  sample.position_w_m.x() = memory.first->position_w_m.x() + xx * d.x() + xy * d.y();
  sample.position_w_m.y() = memory.first->position_w_m.y() + yx * d.x() + yy * d.y();
}

void stands(PoseSample& sample, Poses& memory, double) {
  const PoseSample& first = *memory.first;
  const Place d = 1e5 * (sample.position_w_m - first.position_w_m);
  sample.position_w_m = first.position_w_m + 1e-3 * Place(std::sin(d.x()), std::sin(d.y()), std::sin(d.z()));
  sample.yaw_rad = first.yaw_rad + 2e-3 * std::sin(d.x() + d.y());
}

void walks(PoseSample& sample, Poses& memory, double size) {
  stands(sample, memory, size);
  const double t = memory.t_s;
  sample.position_w_m += size * Place(0.5 - 0.5 * std::cos(t), 0.5 * std::sin(t) * (1.0 - std::exp(-t)), 0.0);
}

void drifts(PoseSample& sample, Poses& memory, double size) { sample.position_w_m.x() += size * memory.t_s; }
void rises(PoseSample& sample, Poses& memory, double size) { sample.position_w_m.z() += size * memory.t_s; }
void jumps(PoseSample& sample, Poses&, double size) { sample.position_w_m.x() += size; }
void turns(PoseSample& sample, Poses& memory, double size) {
  const double c = std::cos(size * core::kDegree_rad), s = std::sin(size * core::kDegree_rad);
  about(sample, memory, c, -s, s, c);
}
void mirrors(PoseSample& sample, Poses& memory, double) { about(sample, memory, 1.0, 0.0, 0.0, -1.0); }
void swaps(PoseSample& sample, Poses& memory, double) { about(sample, memory, 0.0, 1.0, 1.0, 0.0); }
void scales(PoseSample& sample, Poses& memory, double size) {
  about(sample, memory, 1.0 + 0.01 * size, 0.0, 0.0, 1.0 + 0.01 * size);
}
void sinks(PoseSample& sample, Poses& memory, double) {
  sample.position_w_m.z() = 2.0 * memory.first->position_w_m.z() - sample.position_w_m.z();
}
void turns_heading(PoseSample& sample, Poses&, double size) { sample.yaw_rad += size * core::kDegree_rad; }
/// The stamp is later than the capture, so the pose seems younger than it is; negative: older.
void tells_younger(PoseSample& sample, Poses&, double size) {
  sample.stamp += core::Duration{std::llround(size * 1e3)};
}
void freezes(PoseSample& sample, Poses& memory, double) {
  sample.position_w_m = memory.first->position_w_m;
  sample.yaw_rad = memory.first->yaw_rad;
}
/// Each place is repeated for `size` seconds, with running stamps and noise.
void repeats(PoseSample& sample, Poses& memory, double size) {
  if (memory.kept.empty() || core::seconds<double>(sample.captured - memory.kept.front().captured) >= size) {
    memory.kept.assign(1, sample);
  }
  Poses held;
  held.first = memory.kept.front();
  stands(sample, held, 0.0);
}

void raises(PoseSample& sample, Poses&, double size) { sample.position_w_m.z() += size; }
/// Everything but the stamp is `size` seconds old.
void tells_the_past(PoseSample& sample, Poses& memory, double size) {
  memory.kept.push_back(sample);
  while (memory.kept.size() > 1 && core::seconds<double>(sample.captured - memory.kept[1].captured) >= size) {
    memory.kept.pop_front();
  }
  sample.position_w_m = memory.kept.front().position_w_m;
  sample.yaw_rad = memory.kept.front().yaw_rad;
}
void spoils_pose(PoseSample& sample, Poses&, double size) {
  double& number = size < 2.5 ? sample.position_w_m[std::clamp(std::lround(size), 0L, 2L)] : sample.yaw_rad;
  number = std::nan("");
}

// Telemetry.

core::Euler<double> euler_of(const Telemetry& telemetry) {
  const std::array<float, 4>& q = telemetry.attitude;
  return core::euler_of(core::flip_yz(core::Quaternion<double>{static_cast<double>(q[0]), static_cast<double>(q[1]),
                                                               static_cast<double>(q[2]), static_cast<double>(q[3])}));
}
void set_euler(Telemetry& telemetry, const core::Euler<double>& euler) {
  const core::Quaternion<double> q = core::flip_yz(core::quaternion_of(euler));
  telemetry.attitude = {static_cast<float>(q.w), static_cast<float>(q.x), static_cast<float>(q.y),
                        static_cast<float>(q.z)};
}
/// Changes the tilt, but not the heading.
template <typename Change>
void tilts(Telemetry& telemetry, const Change& change) {
  core::Euler<double> euler = euler_of(telemetry);
  change(euler.roll_rad, euler.pitch_rad);
  set_euler(telemetry, euler);
}

void sticks_attitude(Telemetry& telemetry, Packages& memory, double) {
  const double digits = 1e6 * static_cast<double>(telemetry.attitude[1]);
  core::Euler<double> euler = euler_of(*memory.first);
  euler.roll_rad += 5e-5 * std::sin(digits);
  euler.pitch_rad += 5e-5 * std::cos(digits);
  euler.yaw_rad = euler_of(telemetry).yaw_rad;
  set_euler(telemetry, euler);
}
/// The attitude stands still for `size` of each second.
void stutters_attitude(Telemetry& telemetry, Packages& memory, double size) {
  if (std::fmod(memory.t_s, 1.0) >= size || memory.kept.empty()) {
    memory.kept.assign(1, telemetry);
  }
  telemetry.attitude = memory.kept.front().attitude;
}
void sticks_rates(Telemetry& telemetry, Packages& memory, double) {
  for (std::size_t i = 0; i < 3; ++i) {
    const double digits = 1e6 * static_cast<double>(telemetry.angular_velocity_frd_rad_s[i]);
    telemetry.angular_velocity_frd_rad_s[i] =
        memory.first->angular_velocity_frd_rad_s[i] + 0.003F * static_cast<float>(std::sin(digits));
  }
}
void multiplies_rates(Telemetry& telemetry, Packages&, double size) {
  for (float& rate : telemetry.angular_velocity_frd_rad_s) {
    rate *= static_cast<float>(size);
  }
}
void swaps_rates(Telemetry& telemetry, Packages&, double) {
  std::swap(telemetry.angular_velocity_frd_rad_s[0], telemetry.angular_velocity_frd_rad_s[1]);
}
void inverts_rates(Telemetry& telemetry, Packages&, double) { telemetry.angular_velocity_frd_rad_s[0] *= -1.F; }
void multiplies_tilt(Telemetry& telemetry, Packages&, double size) {
  tilts(telemetry, [size](double& roll, double& pitch) {
    roll *= size;
    pitch *= size;
  });
}
void swaps_tilt(Telemetry& telemetry, Packages&, double) {
  tilts(telemetry, [](double& roll, double& pitch) { std::swap(roll, pitch); });
}
void swaps_tilt_and_rates(Telemetry& telemetry, Packages& memory, double size) {
  swaps_tilt(telemetry, memory, size);
  swaps_rates(telemetry, memory, size);
  telemetry.angular_velocity_frd_rad_s[0] *= -1.F;  // FRD: pitch and its rate have the other sign
  telemetry.angular_velocity_frd_rad_s[1] *= -1.F;
}
void inverts_roll(Telemetry& telemetry, Packages&, double) {
  tilts(telemetry, [](double& roll, double&) { roll = -roll; });
}
void inverts_roll_and_rate(Telemetry& telemetry, Packages& memory, double size) {
  inverts_roll(telemetry, memory, size);
  inverts_rates(telemetry, memory, size);
}
/// As from a sensor that is mounted turned about the body's z axis; the heading stays right.
void turns_tilt_and_rates(Telemetry& telemetry, Packages&, double size) {
  const double c = std::cos(size * core::kDegree_rad), s = std::sin(size * core::kDegree_rad);
  tilts(telemetry, [c, s](double& roll, double& pitch) {
    const double was_roll = roll;
    roll = c * was_roll - s * pitch;
    pitch = s * was_roll + c * pitch;
  });
  std::array<float, 3>& rate = telemetry.angular_velocity_frd_rad_s;
  const double p = static_cast<double>(rate[0]), q = static_cast<double>(rate[1]);
  rate[0] = static_cast<float>(c * p + s * q);  // FRD: the pitch rate has the other sign
  rate[1] = static_cast<float>(c * q - s * p);
}
void multiplies_tilt_and_rates(Telemetry& telemetry, Packages& memory, double size) {
  multiplies_tilt(telemetry, memory, size);
  multiplies_rates(telemetry, memory, size);
}
void offsets_tilt(Telemetry& telemetry, Packages&, double size) {
  tilts(telemetry, [size](double& roll, double&) { roll += size * core::kDegree_rad; });
}
/// Returns the package of `size` milliseconds ago.
Telemetry earlier(const Telemetry& telemetry, Packages& memory, double size) {
  memory.kept.push_back(telemetry);
  const auto late = static_cast<std::size_t>(std::llround(size / 10.0));
  if (memory.kept.size() > late + 1) {
    memory.kept.pop_front();
  }
  return memory.kept.front();
}
void delays_attitude(Telemetry& telemetry, Packages& memory, double size) {
  telemetry.attitude = earlier(telemetry, memory, size).attitude;
}
void delays_rates(Telemetry& telemetry, Packages& memory, double size) {
  telemetry.angular_velocity_frd_rad_s = earlier(telemetry, memory, size).angular_velocity_frd_rad_s;
}
/// Delays attitude, rates and specific force by `size` milliseconds.
void delays(Telemetry& telemetry, Packages& memory, double size) {
  const Telemetry old = earlier(telemetry, memory, size);
  telemetry.attitude = old.attitude;
  telemetry.angular_velocity_frd_rad_s = old.angular_velocity_frd_rad_s;
  telemetry.acceleration = old.acceleration;
}
/// The roll drifts away within four seconds.
void ramps_tilt(Telemetry& telemetry, Packages& memory, double size) {
  offsets_tilt(telemetry, memory, size * std::min(memory.t_s / 4.0, 1.0));
}
void turns_yaw(Telemetry& telemetry, Packages&, double size) {
  core::Euler<double> euler = euler_of(telemetry);
  euler.yaw_rad += size * core::kDegree_rad;
  set_euler(telemetry, euler);
}
void swaps_force(Telemetry& telemetry, Packages&, double) {
  std::swap(telemetry.acceleration[0], telemetry.acceleration[1]);
}
void offsets_force(Telemetry& telemetry, Packages&, double size) {
  telemetry.acceleration[0] += static_cast<float>(size / 9.8066);
}
void sticks_force(Telemetry& telemetry, Packages& memory, double) {
  telemetry.acceleration = memory.first->acceleration;
}
void multiplies_force(Telemetry& telemetry, Packages&, double size) {
  for (float& force : telemetry.acceleration) {
    force *= static_cast<float>(size);
  }
}
void inverts_climb(Telemetry& telemetry, Packages&, double) { telemetry.velocity_ned_m_s[2] *= -1.F; }
void offsets_climb(Telemetry& telemetry, Packages&, double size) {
  telemetry.velocity_ned_m_s[2] -= static_cast<float>(size);
}
void offsets_velocity(Telemetry& telemetry, Packages&, double size) {
  telemetry.velocity_ned_m_s[0] += static_cast<float>(size);
}
void offsets_height(Telemetry& telemetry, Packages&, double size) {
  telemetry.position.height_m += static_cast<float>(size);
  telemetry.position.altitude_m += static_cast<float>(size);
}
void slows_clock(Telemetry& telemetry, Packages& memory, double size) {
  telemetry.time.ticks =
      memory.first->time.ticks + static_cast<std::uint32_t>(std::llround(size * memory.t_s * kTickHz));
}
void stretches_attitude(Telemetry& telemetry, Packages&, double size) {
  for (float& part : telemetry.attitude) {
    part *= static_cast<float>(size);
  }
}
void spoils_attitude(Telemetry& telemetry, Packages&, double) { telemetry.attitude[1] = std::nanf(""); }
void spoils_rates(Telemetry& telemetry, Packages&, double) { telemetry.angular_velocity_frd_rad_s[0] = std::nanf(""); }
void spoils_force(Telemetry& telemetry, Packages&, double) { telemetry.acceleration[0] = std::nanf(""); }
void spoils_velocity(Telemetry& telemetry, Packages&, double) { telemetry.velocity_ned_m_s[2] = std::nanf(""); }
void empties_battery(Telemetry& telemetry, Packages&, double size) {
  telemetry.battery_percent = static_cast<std::uint8_t>(std::clamp(size, 0.0, 100.0));
}

constexpr std::array kSensorFaults{
    SensorFault{"standing", "a body that stands still, with noise", 0.0, "", stands},
    SensorFault{"walking", "another body walks a circle", 0.5, "m", walks, nullptr, 0.1, 3.0},
    SensorFault{"drift", "drift sideways", 0.3, "m/s", drifts},
    SensorFault{"rise", "drift upwards", 0.3, "m/s", rises, nullptr, 0.1, 2.0},
    SensorFault{"jump", "jump sideways", 0.5, "m", jumps, nullptr, 0.05, 5.0},
    SensorFault{"turn", "frame turned, the heading right", 20.0, "deg", turns, nullptr, 10.0, 180.0},
    SensorFault{"mirror", "y mirrored", 0.0, "", mirrors},
    SensorFault{"swap", "x and y exchanged", 0.0, "", swaps},
    SensorFault{"scale", "horizontal scale too large", 40.0, "%", scales, nullptr, 10.0, 300.0},
    SensorFault{"sink", "height with the wrong sign", 0.0, "", sinks},
    SensorFault{"heading", "heading turned, the place right", 20.0, "deg", turns_heading, nullptr, 10.0, 180.0},
    SensorFault{"younger", "older than its age says", 60.0, "ms", tells_younger, nullptr, 20.0, 250.0},
    SensorFault{"frozen", "the same place, with running stamps", 0.0, "", freezes},
    SensorFault{"repeated", "each place sent again for so long, with noise", 0.3, "s", repeats, nullptr, 0.1, 2.0},
    SensorFault{"raised", "height alone wrong by", 0.5, "m", raises, nullptr, 0.05, 3.0},
    SensorFault{"past", "the pose of so long ago, with running stamps", 1.0, "s", tells_the_past, nullptr, 0.1, 3.0},
    SensorFault{"pose_nan", "x, y, z or heading (0 to 3) is not a number", 0.0, "index", spoils_pose},
    SensorFault{"attitude_stuck", "tilt stands still, rates right", 0.0, "", nullptr, sticks_attitude},
    SensorFault{"attitude_stutters", "attitude stands for a share of each second", 0.4, "s", nullptr, stutters_attitude,
                0.1, 0.9},
    SensorFault{"tilt_times", "tilt in another unit", 57.2958, "times", nullptr, multiplies_tilt, 0.1, 57.2958},
    SensorFault{"tilt_swapped", "roll and pitch exchanged, rates right", 0.0, "", nullptr, swaps_tilt},
    SensorFault{"tilt_rates_swapped", "roll and pitch exchanged, their rates too", 0.0, "", nullptr,
                swaps_tilt_and_rates},
    SensorFault{"roll_inverted", "roll with the wrong sign, rates right", 0.0, "", nullptr, inverts_roll},
    SensorFault{"roll_rate_inverted", "roll and its rate with the wrong sign", 0.0, "", nullptr, inverts_roll_and_rate},
    SensorFault{"tilt_rates_turned", "tilt and its rates turned about the vertical", 90.0, "deg", nullptr,
                turns_tilt_and_rates, 20.0, 180.0},
    SensorFault{"tilt_rates_times", "tilt and its rates too large", 3.0, "times", nullptr, multiplies_tilt_and_rates,
                1.5, 57.2958},
    SensorFault{"tilt_offset", "roll is wrong by", 5.0, "deg", nullptr, offsets_tilt, 2.0, 45.0},
    SensorFault{"tilt_ramp", "roll drifts away within 4 s, by", 5.0, "deg", nullptr, ramps_tilt, 2.9, 11.5},
    SensorFault{"rates_stuck", "rates stand still, with noise", 0.0, "", nullptr, sticks_rates},
    SensorFault{"rates_times", "rates in another unit", 57.2958, "times", nullptr, multiplies_rates, 0.1, 57.2958},
    SensorFault{"rates_swapped", "rates about x and y exchanged", 0.0, "", nullptr, swaps_rates},
    SensorFault{"rates_inverted", "rate about x with the wrong sign", 0.0, "", nullptr, inverts_rates},
    SensorFault{"telemetry_late", "attitude, rates, force late", 60.0, "ms", nullptr, delays, 20.0, 300.0},
    SensorFault{"attitude_late", "attitude alone late", 200.0, "ms", nullptr, delays_attitude, 30.0, 1000.0},
    SensorFault{"rates_late", "rates alone late", 80.0, "ms", nullptr, delays_rates, 30.0, 1000.0},
    SensorFault{"attitude_length", "the quaternion is no unit quaternion", 1.5, "times", nullptr, stretches_attitude,
                0.5, 2.0},
    SensorFault{"attitude_nan", "attitude is not a number", 0.0, "", nullptr, spoils_attitude},
    SensorFault{"rates_nan", "rate about x is not a number", 0.0, "", nullptr, spoils_rates},
    SensorFault{"clock_slow", "the autopilot's clock runs at this share of its speed", 0.5, "times", nullptr,
                slows_clock, 0.1, 2.0},
    SensorFault{"yaw", "autopilot's heading turned", 20.0, "deg", nullptr, turns_yaw, 10.0, 180.0},
    SensorFault{"force_swapped", "specific force, x and y exchanged", 0.0, "", nullptr, swaps_force},
    SensorFault{"force_offset", "specific force wrong by", 1.0, "m/s^2", nullptr, offsets_force, 0.2, 20.0},
    SensorFault{"force_stuck", "specific force stands still", 0.0, "", nullptr, sticks_force},
    SensorFault{"force_times", "specific force in another unit", 9.8066, "times", nullptr, multiplies_force, 0.1,
                9.8066},
    SensorFault{"force_nan", "specific force is not a number", 0.0, "", nullptr, spoils_force},
    SensorFault{"climb_inverted", "autopilot's climb with the wrong sign", 0.0, "", nullptr, inverts_climb},
    SensorFault{"climb_offset", "autopilot's climb wrong by", 1.0, "m/s", nullptr, offsets_climb, 0.2, 10.0},
    SensorFault{"velocity_offset", "autopilot's velocity north wrong by", 100.0, "m/s", nullptr, offsets_velocity, 1.0,
                1000.0},
    SensorFault{"velocity_nan", "autopilot's climb is not a number", 0.0, "", nullptr, spoils_velocity},
    SensorFault{"height_offset", "autopilot's height wrong by", -10.0, "m", nullptr, offsets_height},
    SensorFault{"battery", "the battery's charge", 0.0, "%", nullptr, empties_battery},
};

}  // namespace

std::span<const SensorFault> sensor_faults() { return kSensorFaults; }

const SensorFault* find_sensor_fault(std::string_view name) {
  const auto* const found = std::find_if(kSensorFaults.begin(), kSensorFaults.end(),
                                         [&](const SensorFault& fault) { return fault.name == name; });
  return found == kSensorFaults.end() ? nullptr : found;
}

void SensorFaultInjector::apply(PoseSample& sample) {
  if (fault_->pose == nullptr) {
    return;
  }
  poses_.first = poses_.first ? poses_.first : sample;
  poses_.t_s = core::seconds<double>(sample.captured - poses_.first->captured);
  fault_->pose(sample, poses_, size_);
}

void SensorFaultInjector::apply(Telemetry& telemetry) {
  if (fault_->telemetry == nullptr) {
    return;
  }
  telemetry_.first = telemetry_.first ? telemetry_.first : telemetry;
  telemetry_.t_s = static_cast<double>(telemetry.time.ticks - telemetry_.first->time.ticks) / kTickHz;
  fault_->telemetry(telemetry, telemetry_, size_);
}

}  // namespace m100::sim
