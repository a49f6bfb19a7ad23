// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/sim/world/vehicle_port.h"

namespace m100::sim {

/// A vehicle that hovers whatever its command is, and stores the last command: for tests of the link.
class StillVehicle final : public VehiclePort {
 public:
  StillVehicle() {
    state_.position_w_m.z() = 1.5;
    state_.motors_on = true;
    state_.in_air = true;
  }
  void command(const VehicleInput& input) override { last_ = input; }
  void set_motors(bool on) override { state_.motors_on = on; }
  void advance(core::Duration step) override { age_ += step; }
  const VehicleState& state() const override { return state_; }

  VehicleState& mutable_state() { return state_; }
  const VehicleInput& last_input() const { return last_; }
  core::Duration age() const { return age_; }

 private:
  VehicleState state_;
  VehicleInput last_;
  core::Duration age_{0};
};

}  // namespace m100::sim
