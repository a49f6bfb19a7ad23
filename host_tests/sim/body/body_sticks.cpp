// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/body_sticks.h"

#include <array>

namespace m100::sim {
namespace {

using model::StickAxis;

constexpr std::array kDynamics{&StickAxis::time_constant_s,   &StickAxis::natural_frequency_rad_s,
                               &StickAxis::damping_ratio,     &StickAxis::lead_zero_s,
                               &StickAxis::transport_delay_s, &StickAxis::rate_limit_per_s};

StickAxis stick_only(StickAxis axis) {
  for (double StickAxis::*const number : kDynamics) {
    axis.*number = 0.0;
  }
  return axis;
}

}  // namespace

std::span<double StickAxis::*const> dynamics_numbers() { return kDynamics; }

BodySticks::BodySticks(const Plant& plant)
    : plant_(plant),
      roll_(stick_only(plant.roll), plant.link.command_delay_s),
      pitch_(stick_only(plant.pitch), plant.link.command_delay_s),
      yaw_rate_(stick_only(plant.yaw_rate), plant.link.command_delay_s),
      climb_(stick_only(plant.climb), plant.link.command_delay_s) {}

void BodySticks::command(const VehicleInput& input) { set_command(input, roll_, pitch_, climb_, yaw_rate_); }

void BodySticks::change() {
  plant_ = changed(plant_);
  plant_.change.steps.clear();
  roll_.set_parameters(stick_only(plant_.roll));
  pitch_.set_parameters(stick_only(plant_.pitch));
  yaw_rate_.set_parameters(stick_only(plant_.yaw_rate));
  climb_.set_parameters(stick_only(plant_.climb));
}

void BodySticks::advance(double step_s) {
  if (world_time_s_ && !plant_.change.steps.empty() && *world_time_s_ >= plant_.change.at_s) {
    change();
  }
  const double roll_command = roll_.commanded();
  const double pitch_command = pitch_.commanded();
  roll_.advance(step_s, plant_.roll.cross_axis * pitch_command);
  pitch_.advance(step_s, plant_.pitch.cross_axis * roll_command);
  yaw_rate_.advance(step_s, 0.0);
  climb_.advance(step_s, 0.0);
  if (world_time_s_) {
    *world_time_s_ += step_s;
  }
}

BodyCommand BodySticks::output() const {
  return {.roll_rad = roll_.output(),
          .pitch_rad = pitch_.output(),
          .climb_m_s = climb_.output(),
          .yaw_rate_rad_s = -yaw_rate_.output()};
}

}  // namespace m100::sim
