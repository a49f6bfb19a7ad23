// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>

#include "host_tests/sim/body/body_control.h"
#include "host_tests/sim/world/axis_motion.h"
#include "host_tests/sim/world/plant.h"
#include "host_tests/sim/world/vehicle_port.h"

namespace m100::sim {

/// The numbers of an axis that come after its stick's law: of the identified response, not of a body's sticks.
std::span<double model::StickAxis::*const> dynamics_numbers();

/// The sticks and movement commands of a body: the laws of [axis.*], their change in flight, and link.command_delay_s.
class BodySticks {
 public:
  explicit BodySticks(const Plant& plant);

  /// The world's time begins: [change] counts from here.
  void start_time() { world_time_s_ = 0.0; }
  void command(const VehicleInput& input);
  void advance(double step_s);
  /// What the loops have to follow.
  BodyCommand output() const;

 private:
  void change();

  Plant plant_;
  AxisMotion roll_;
  AxisMotion pitch_;
  AxisMotion yaw_rate_;
  AxisMotion climb_;
  std::optional<double> world_time_s_;  ///< none: not begun
};

}  // namespace m100::sim
