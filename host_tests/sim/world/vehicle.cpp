// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/world/vehicle.h"

#include <algorithm>
#include <cmath>

namespace m100::sim {
namespace {

constexpr double kStep_s = 0.001;  // of the integration
// While the sticks rest, roll, pitch and climb wander at about 1 Hz (autocorrelation of the measured logs), yaw slower.
constexpr double kTiltWander_rad_s = 6.0;
constexpr double kClimbWander_rad_s = 5.0;
constexpr double kHeadingWander_rad_s = 4.0;
constexpr double kBatteryLife_s = 840.0;   // 14 minutes (paper, IV-A)
constexpr double kRotorRadius_m = 0.1651;  // 13 inches across
constexpr double kLowestRotor_m = 0.15;    // the rotors stand above the feet
const core::Vector<double, 3> kUp(0.0, 0.0, 1.0);

core::Vector<double, 3> cross(const core::Vector<double, 3>& a, const core::Vector<double, 3>& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}

core::Vector<double, 3> into_body(const core::Quaternion<double>& q, const core::Vector<double, 3>& v) {
  const core::Vector<double, 3> axis(-q.x, -q.y, -q.z);
  const core::Vector<double, 3> twice = 2.0 * cross(axis, v);
  return v + q.w * twice + cross(axis, twice);
}

}  // namespace

Vehicle::Vehicle(const Plant& plant, std::uint64_t seed, const core::Vector<double, 3>& position_w_m, double yaw_rad)
    : plant_(plant),
      wind_(plant.air, seed),
      random_(seed, "vehicle"),
      roll_(plant.roll, plant.link.command_delay_s),
      pitch_(plant.pitch, plant.link.command_delay_s),
      yaw_rate_(plant.yaw_rate, plant.link.command_delay_s),
      climb_(plant.climb, plant.link.command_delay_s),
      roll_wander_(plant.air.attitude_disturbance_rad, kTiltWander_rad_s),
      pitch_wander_(plant.air.attitude_disturbance_rad, kTiltWander_rad_s),
      heading_air_{.held = {plant.air.yaw_rate_disturbance_rad_s / kHeadingWander_rad_s, kHeadingWander_rad_s},
                   .random = {seed, "turn"},
                   .turn = {plant.air.turn_disturbance_rad_s, 1.0 / kHeadingWander_rad_s}},
      climb_wander_(plant.air.climb_disturbance_m_s, kClimbWander_rad_s),
      yaw_rad_(yaw_rad) {
  state_.position_w_m = position_w_m;
  state_.motors_on = true;
  state_.in_air = position_w_m.z() > 0.0;
  state_.battery_percent = plant.battery.start_percent;
  load_ = CarriedLoad(carried_kg());
  attitude_.yaw_rad = yaw_rad;
  publish(core::Vector<double, 3>::Zero());
}

void Vehicle::command(const VehicleInput& input) { set_command(input, roll_, pitch_, climb_, yaw_rate_); }

void Vehicle::advance(core::Duration step) {
  const double total_s = core::seconds<double>(step);
  // An autopilot's clock that drifts makes steps of 2.4998 ms: three parts, as of 2.5 ms.
  const int parts = std::max(1, static_cast<int>(std::ceil(total_s / kStep_s - 1e-6)));
  core::Vector<double, 3> acceleration = core::Vector<double, 3>::Zero();
  for (int part = 0; part < parts; ++part) {
    acceleration = integrate(total_s / parts);
  }
  publish(acceleration);
}

core::Vector<double, 3> Vehicle::aerodynamic_acceleration(const core::Vector<double, 3>& wind) const {
  const core::Vector<double, 3> relative = state_.velocity_w_m_s - wind;
  const double mass_ratio = plant_.mass_kg / (plant_.mass_kg + carried_kg());
  const model::Moment moment{.time_s = time_s_,
                             .air_velocity_w_m_s = {relative.x(), relative.y(), relative.z()},
                             .heading_cosine = std::cos(attitude_.yaw_rad),
                             .heading_sine = std::sin(attitude_.yaw_rad)};
  const model::Acceleration sum = model::outer_acceleration(plant_.air, moment, mass_ratio);
  return {sum[0], sum[1], sum[2]};
}

double Vehicle::authority() const {
  const double drained = plant_.battery.sag * (1.0 - 0.01 * state_.battery_percent);
  const double loaded =
      plant_.payload.slung_length_m > 0.0 ? 1.0 : std::sqrt(plant_.mass_kg / (plant_.mass_kg + carried_kg()));
  return actuators_ * loaded * (1.0 - drained);
}

void Vehicle::change_when_due() {
  if (has_changed_ || plant_.change.steps.empty() || time_s_ < plant_.change.at_s) {
    return;
  }
  has_changed_ = true;
  plant_ = changed(plant_);
  roll_.set_parameters(plant_.roll);
  pitch_.set_parameters(plant_.pitch);
  yaw_rate_.set_parameters(plant_.yaw_rate);
  climb_.set_parameters(plant_.climb);
  wind_.set_parameters(plant_.air);
  roll_wander_.set_sigma(plant_.air.attitude_disturbance_rad);
  pitch_wander_.set_sigma(plant_.air.attitude_disturbance_rad);
  heading_air_.held.set_sigma(plant_.air.yaw_rate_disturbance_rad_s / kHeadingWander_rad_s);
  climb_wander_.set_sigma(plant_.air.climb_disturbance_m_s);
  heading_air_.turn.set_parameters(plant_.air.turn_disturbance_rad_s, 1.0 / kHeadingWander_rad_s);
}

double Vehicle::climb_offset_m_s(double step_s) {
  const double sag_m_s = load_.sag_m_s(step_s, carried_kg(), plant_.mass_kg);
  if (plant_.air.ground_effect == 0.0) {
    return sag_m_s;
  }
  const double ratio = 0.25 * kRotorRadius_m / (kLowestRotor_m + std::max(0.0, state_.position_w_m.z()));
  const double lift = ratio * ratio / (1.0 - ratio * ratio);
  return sag_m_s + plant_.air.ground_effect * CarriedLoad::kHeightLoop_s * model::kGravity_m_s2 * lift;
}

core::Vector<double, 3> Vehicle::integrate(double step_s) {
  change_when_due();
  const double authority = this->authority();
  const double roll_command = roll_.commanded();
  const double pitch_command = pitch_.commanded();
  roll_.advance(step_s, plant_.roll.cross_axis * pitch_command, authority);
  pitch_.advance(step_s, plant_.pitch.cross_axis * roll_command, authority);
  yaw_rate_.advance(step_s, 0.0, authority);
  climb_.advance(step_s, 0.0, authority);

  roll_wander_.advance(step_s, random_);
  pitch_wander_.advance(step_s, random_);
  heading_air_.held.advance(step_s, random_);
  climb_wander_.advance(step_s, random_);
  attitude_.roll_rad = roll_.output() + roll_wander_.value();
  attitude_.pitch_rad = pitch_.output() + pitch_wander_.value();
  yaw_rad_ += step_s * (heading_air_.turn.advance(step_s, heading_air_.random) - yaw_rate_.output());
  attitude_.yaw_rad = std::remainder(yaw_rad_ + heading_air_.held.value(), 2.0 * core::kPi);

  const core::Vector<double, 3> wind = wind_.advance(step_s);
  const core::Vector<double, 3> air = aerodynamic_acceleration(wind);
  const double climb_before = state_.velocity_w_m_s.z();
  // The autopilot's climb loop compensates most of the vertical air force; the measured wander remains.
  const double climb = climb_.output() + climb_wander_.value() + climb_offset_m_s(step_s);
  const double lift_wanted = model::kGravity_m_s2 + std::clamp((climb - climb_before) / step_s, -6.0, 6.0);
  lift_m_s2_ = plant_.air.thrust_lag_s > 0.0
                   ? lift_m_s2_ + (1.0 - std::exp(-step_s / plant_.air.thrust_lag_s)) * (lift_wanted - lift_m_s2_)
                   : lift_wanted;
  const double lift = plant_.air.tilt_gain * lift_m_s2_;
  const double sr = std::sin(attitude_.roll_rad), cr = std::cos(attitude_.roll_rad);
  const double sp = std::sin(attitude_.pitch_rad), cp = std::cos(attitude_.pitch_rad);
  const double forward = lift * sp / cp;
  const double left = -lift * sr / (cr * cp);
  const double cy = std::cos(attitude_.yaw_rad), sy = std::sin(attitude_.yaw_rad);
  core::Vector<double, 3> acceleration(cy * forward - sy * left + air.x(), sy * forward + cy * left + air.y(), 0.0);
  acceleration += load_.swing(step_s, plant_.payload.slung_length_m, carried_kg(), plant_.mass_kg, acceleration);
  acceleration.z() = (climb - climb_before) / step_s;

  state_.position_w_m += step_s * (state_.velocity_w_m_s + 0.5 * step_s * acceleration);
  state_.velocity_w_m_s += step_s * acceleration;
  const bool stays_down = !state_.motors_on && !state_.in_air;
  if (state_.position_w_m.z() <= 0.0 || stays_down) {
    hardest_touch_m_s_ = std::max(hardest_touch_m_s_, -state_.velocity_w_m_s.z());
    state_.position_w_m.z() = 0.0;
    state_.velocity_w_m_s.setZero();
    acceleration.setZero();  // the ground carries it
  }
  state_.in_air = state_.position_w_m.z() > 0.0;
  state_.battery_percent = std::max(0.0, plant_.battery.start_percent - 100.0 * time_s_ / kBatteryLife_s);
  time_s_ += step_s;
  return acceleration;
}

void Vehicle::publish(const core::Vector<double, 3>& acceleration) {
  const double cr = std::cos(0.5 * attitude_.roll_rad), sr = std::sin(0.5 * attitude_.roll_rad);
  const double cp = std::cos(0.5 * attitude_.pitch_rad), sp = std::sin(0.5 * attitude_.pitch_rad);
  const double cy = std::cos(0.5 * attitude_.yaw_rad), sy = std::sin(0.5 * attitude_.yaw_rad);
  state_.rotation_wb = {.w = cr * cp * cy + sr * sp * sy,
                        .x = sr * cp * cy - cr * sp * sy,
                        .y = cr * sp * cy + sr * cp * sy,
                        .z = cr * cp * sy - sr * sp * cy};
  // Body rates from the rates of the z-y-x angles.
  const double roll_rate = roll_.output_rate() + roll_wander_.rate();
  const double pitch_rate = pitch_.output_rate() + pitch_wander_.rate();
  const double yaw_rate = heading_air_.held.rate() + heading_air_.turn.value() - yaw_rate_.output();
  const double sin_roll = std::sin(attitude_.roll_rad), cos_roll = std::cos(attitude_.roll_rad);
  const double sin_pitch = std::sin(attitude_.pitch_rad), cos_pitch = std::cos(attitude_.pitch_rad);
  state_.rate_b_rad_s = {roll_rate - sin_pitch * yaw_rate, cos_roll * pitch_rate + sin_roll * cos_pitch * yaw_rate,
                         -sin_roll * pitch_rate + cos_roll * cos_pitch * yaw_rate};
  state_.specific_force_b_m_s2 = into_body(state_.rotation_wb, acceleration + kUp * model::kGravity_m_s2);
}

}  // namespace m100::sim
