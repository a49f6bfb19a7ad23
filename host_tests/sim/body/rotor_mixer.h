// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

namespace m100::sim {

/// Order of ArduPilot's quadrotor in "X": front right (turns counter-clockwise), rear left (counter-clockwise), front
/// left (clockwise), rear right (clockwise).
using RotorNumbers = std::array<double, 4>;

/// Demands as thrust, in shares of a rotor's full thrust. Torques in FLU: +roll right side down, +pitch nose down,
/// +yaw counter-clockwise. A torque of 1 raises two rotors by 1 and lowers two by 1.
struct RotorDemand {
  double collective = 0.0;
  double roll = 0.0;
  double pitch = 0.0;
  double yaw = 0.0;
};

/// Shares the demands out to four rotors that give between kIdle and 1. Where they do not fit, yaw gives way first,
/// then the collective thrust moves as little as it must, and roll and pitch shrink together only where they alone need
/// more than the whole range.
class RotorMixer {
 public:
  static constexpr double kIdle = 0.02;   ///< so that no rotor stops in flight
  static constexpr double kMaxYaw = 0.3;  ///< share of the collective thrust that yaw may take: the rest carries
  /// @returns each rotor's thrust.
  static RotorNumbers mix(const RotorDemand& demand);
};

/// The throttle at which a rotor gives this thrust, both 0 to 1, if thrust = (1 - curve) u + curve u^2.
double throttle_of(double thrust, double curve);

}  // namespace m100::sim
