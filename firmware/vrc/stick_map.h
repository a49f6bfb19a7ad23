// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/expected.h"
#include "firmware/model/vehicle.h"
#include "firmware/vrc/sticks.h"

namespace m100::vrc {

/// One stick: the autopilot's mapping from counts to a command, and its inverse.
///   u = counts - neutral;  dead zone (half width w): continuous u -> sign(u)(|u| - w), jump: u inside w -> 0
///   curve u -> sign(u) 660 (|u| / 660)^exponent;  command = sign * scale * u, a scale per side if it is asymmetric
/// In SI of the axis: rad (roll, pitch), m/s (throttle), rad/s (yaw).
struct StickMap {
  float scale_si_per_vrc = 1.F;
  float neutral_vrc = 1024.F;  ///< the stick's trim (paper, III-B.3)
  float dead_zone_vrc = 0.F;   ///< half width
  model::DeadZoneShape shape = model::DeadZoneShape::kJump;
  float exponent = 1.F;
  float gain_asymmetry = 1.F;  ///< gain of sticks above neutral over that below; the mean is the scale
  float sign = 1.F;            ///< -1 where the larger stick is the smaller command (yaw)

  /// The stick that gives a command, rounded to a count and limited to the travel. It compensates the dead zone (paper,
  /// III-B.5). Shape continuous: the half width is added. Shape jump: a stick inside the zone is moved to the first
  /// count outside it. A command of zero gives neutral. kOutOfRange: the command is not finite.
  core::Expected<Stick> to_stick(float command_si) const;
  /// The command that the autopilot derives from a stick.
  float to_command(Stick stick) const;
};

}  // namespace m100::vrc
