// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/body.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/model/vehicle.h"

namespace m100::sim {
namespace {

using Vector3 = core::Vector<double, 3>;
using Pulses = std::array<std::uint16_t, 16>;

constexpr double kOnGround_s = 1.0;     // time for the physics program to let the body settle on its feet
constexpr double kCalibration_s = 0.5;  // the last part of it
constexpr double kLiftedOff_m = 0.05;
constexpr double kFreeFall = 0.5;           // share of gravity below which nothing carries the body
constexpr double kBarometerDrift_s = 30.0;  // as in the reported height
constexpr double kSameTime_s = 1e-6;
constexpr double kBatteryLife_s = 840.0;  // 14 minutes (paper, IV-A)

Pulses pulses_of(const RotorNumbers& throttle) {
  Pulses pulses{};
  pulses.fill(1000);
  for (std::size_t i = 0; i < throttle.size(); ++i) {
    pulses[i] = static_cast<std::uint16_t>(std::lround(1000.0 + 1000.0 * std::clamp(throttle[i], 0.0, 1.0)));
  }
  return pulses;
}

}  // namespace

Body::Body(const Plant& plant, std::uint64_t seed, const PhysicsAddress& address)
    : link_(address, static_cast<std::uint16_t>(std::lround(plant.autopilot.rate_hz))),
      sticks_(plant),
      control_(plant.autopilot),
      attitude_(plant.autopilot.accelerometer_gain_per_s),
      climb_filter_(plant.autopilot.barometer_s),
      barometer_(plant.sensors.height_drift_m, kBarometerDrift_s),
      random_(seed, "body"),
      step_s_(1.0 / plant.autopilot.rate_hz),
      start_percent_(plant.battery.start_percent),
      battery_percent_(start_percent_) {
  wait_on_ground();
}

bool Body::falls(const PhysicsAnswer& now) const {
  return now.specific_force_b_m_s2.norm() < kFreeFall * model::kGravity_m_s2;
}

void Body::wait_on_ground() {
  now_ = link_.exchange(pulses_of({}));
  const double began_s = now_.time_s;
  Vector3 rate = Vector3::Zero(), force = Vector3::Zero();
  double count = 0.0;
  // A world without ground lets the body fall: then it has to fly at once, level, without a calibration.
  while (now_.time_s - began_s < kOnGround_s && !falls(now_)) {
    if (now_.time_s - began_s >= kOnGround_s - kCalibration_s) {
      rate += now_.rate_b_rad_s;
      force += now_.specific_force_b_m_s2;
      count += 1.0;
    }
    now_ = link_.exchange(pulses_of({}));
  }
  const bool calibrated = count > 0.0;
  attitude_.reset(calibrated ? Vector3(rate / count) : Vector3(Vector3::Zero()),
                  calibrated ? Vector3(force / count) : Vector3(0.0, 0.0, model::kGravity_m_s2),
                  core::yaw_of(now_.rotation_wb));
  climb_filter_.reset(now_.position_w_m.z());
  ground_m_ = now_.position_w_m.z();
  own_time_s_ = now_.time_s;
  publish();
}

void Body::start_time() {
  sticks_.start_time();
  battery_percent_ = start_percent_;
}

void Body::advance(core::Duration step) {
  const double total_s = core::seconds<double>(step);
  own_time_s_ += total_s;
  battery_percent_ = std::max(0.0, battery_percent_ - 100.0 * total_s / kBatteryLife_s);
  while (now_.time_s < own_time_s_ - kSameTime_s) {
    step_physics();
  }
  publish();
}

void Body::step_physics() {
  const core::Euler<double> attitude = core::euler_of(attitude_.rotation_wb());
  const RotorNumbers throttle = control_.update(sticks_.output(),
                                                {.attitude = attitude,
                                                 .rate_b_rad_s = attitude_.rate_b_rad_s(),
                                                 .climb_m_s = climb_filter_.climb_m_s(),
                                                 .in_air = state_.in_air},
                                                step_s_);
  const double before_s = now_.time_s;
  now_ = link_.exchange(pulses_of(state_.motors_on ? throttle : RotorNumbers{}));
  step_s_ = now_.time_s - before_s;
  sticks_.advance(step_s_);
  // A compass is not simulated: the heading that corrects the gyro's drift is the true one.
  attitude_.update(now_.rate_b_rad_s, now_.specific_force_b_m_s2, core::yaw_of(now_.rotation_wb), step_s_);
  const double barometer_m = now_.position_w_m.z() + barometer_.advance(step_s_, random_);
  climb_filter_.update(attitude_.vertical_acceleration_m_s2(now_.specific_force_b_m_s2), barometer_m, step_s_);
  state_.in_air = now_.position_w_m.z() > ground_m_ + kLiftedOff_m || falls(now_);
}

void Body::publish() {
  state_.position_w_m = now_.position_w_m + (own_time_s_ - now_.time_s) * now_.velocity_w_m_s;
  state_.velocity_w_m_s = now_.velocity_w_m_s;
  state_.rotation_wb = now_.rotation_wb;
  state_.rate_b_rad_s = now_.rate_b_rad_s;
  state_.specific_force_b_m_s2 = now_.specific_force_b_m_s2;
  state_.battery_percent = battery_percent_;
  estimated_ = state_;
  estimated_.rotation_wb = attitude_.rotation_wb();
  estimated_.rate_b_rad_s = attitude_.rate_b_rad_s();
}

}  // namespace m100::sim
