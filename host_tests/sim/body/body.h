// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/sim/body/attitude_filter.h"
#include "host_tests/sim/body/body_control.h"
#include "host_tests/sim/body/body_sticks.h"
#include "host_tests/sim/body/climb_filter.h"
#include "host_tests/sim/body/physics_link.h"
#include "host_tests/sim/world/plant.h"
#include "host_tests/sim/world/random.h"
#include "host_tests/sim/world/vehicle_port.h"

namespace m100::sim {

/// An aircraft whose physics another program computes (SIM_JSON), flown by the autopilot's own filters and loops.
///
/// From the plant it takes the sticks of [axis.*] and their change, their delay ([link]), [autopilot], the barometer's
/// drift and the battery's charge (body_plant.h). Dynamics, air and mass are the physics program's. The state is the
/// truth that it reports; estimated() has the attitude of the filter instead. Where its step is not ours, the state is
/// carried to our time along its velocity (at most one step: 0.5 mm at 10 m/s^2 and 10 ms).
///
/// Every call that advances time may throw PhysicsError.
class Body final : public VehiclePort {
 public:
  /// Connects, resets the physics program, waits on the ground, and calibrates the sensors there.
  Body(const Plant& plant, std::uint64_t seed, const PhysicsAddress& address);

  /// The world's time begins: [change] counts from here, and the battery has its start_percent.
  void start_time();
  void command(const VehicleInput& input) override { sticks_.command(input); }
  void set_motors(bool on) override { state_.motors_on = on; }
  void advance(core::Duration step) override;
  const VehicleState& state() const override { return state_; }
  const VehicleState& estimated() const override { return estimated_; }

  double hover_thrust() const { return control_.hover_thrust(); }
  const PhysicsLink& link() const { return link_; }

 private:
  void wait_on_ground();
  void step_physics();
  void publish();
  bool falls(const PhysicsAnswer& now) const;

  PhysicsLink link_;
  BodySticks sticks_;
  BodyControl control_;
  AttitudeFilter attitude_;
  ClimbFilter climb_filter_;
  ColouredNoise barometer_;
  Random random_;
  PhysicsAnswer now_;
  double step_s_;            ///< of the physics program, the last one
  double own_time_s_ = 0.0;  ///< on the clock of the physics program
  double ground_m_ = 0.0;    ///< height at which the body stands
  double start_percent_;
  double battery_percent_;
  VehicleState state_;
  VehicleState estimated_;
};

}  // namespace m100::sim
