// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <variant>

#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "firmware/core/time.h"

namespace m100::sim {

/// True state of the simulated aircraft, without sensor errors. World north-west-up, body forward-left-up, SI.
struct VehicleState {
  core::Vector<double, 3> position_w_m = core::Vector<double, 3>::Zero();
  core::Vector<double, 3> velocity_w_m_s = core::Vector<double, 3>::Zero();
  core::Quaternion<double> rotation_wb{};  ///< turns body vectors into world vectors
  core::Vector<double, 3> rate_b_rad_s = core::Vector<double, 3>::Zero();
  /// Specific force of an ideal accelerometer, body frame: (0, 0, +g) at rest.
  core::Vector<double, 3> specific_force_b_m_s2 = core::Vector<double, 3>(0.0, 0.0, 9.8066);
  double battery_percent = 100.0;
  bool motors_on = false;
  bool in_air = false;
};

/// Stick positions as the autopilot's attitude loops receive them, from the virtual or from the pilot's transmitter:
/// counts 364..1684, centre 1024; right, forward, up, right (clockwise) are the larger numbers.
struct StickInput {
  double roll_vrc = 1024.0;
  double pitch_vrc = 1024.0;
  double throttle_vrc = 1024.0;
  double yaw_vrc = 1024.0;
};

/// A movement command (angle, vertical velocity, yaw rate, body frame) in our frames: +roll right side down, +pitch
/// nose down, +climb up, +yaw rate counter-clockwise.
struct MovementInput {
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  double climb_m_s = 0.0;
  double yaw_rate_rad_s = 0.0;
};

using VehicleInput = std::variant<StickInput, MovementInput>;

/// Hands a command to the motions of its axes.
template <typename Attitude, typename Climb, typename YawRate>
void set_command(const VehicleInput& input, Attitude& roll, Attitude& pitch, Climb& climb, YawRate& yaw_rate) {
  if (const auto* const sticks = std::get_if<StickInput>(&input)) {
    roll.set_stick(sticks->roll_vrc);
    pitch.set_stick(sticks->pitch_vrc);
    climb.set_stick(sticks->throttle_vrc);
    yaw_rate.set_stick(sticks->yaw_vrc);
    return;
  }
  const auto& movement = std::get<MovementInput>(input);
  roll.set_direct(movement.roll_rad);
  pitch.set_direct(movement.pitch_rad);
  climb.set_direct(movement.climb_m_s);
  yaw_rate.set_direct(-movement.yaw_rate_rad_s);  // the yaw stick is positive to the right
}

/// The aircraft that the emulated autopilot controls: attitude loops, airframe, wind. The autopilot selects the command
/// (pilot, virtual sticks, movement commands, none) and passes it on; the vehicle flies it.
class VehiclePort {
 public:
  VehiclePort(const VehiclePort&) = delete;
  VehiclePort& operator=(const VehiclePort&) = delete;

  /// The command in force until the next call. Centred sticks mean "no command": level, height held.
  virtual void command(const VehicleInput& input) = 0;
  /// Motors by request (arm command, take-off task, stick gesture). Ignored by vehicles that are always in the air.
  virtual void set_motors(bool on) = 0;
  /// Advances time: step > 0, at most 10 ms.
  virtual void advance(core::Duration step) = 0;
  virtual const VehicleState& state() const = 0;
  /// The state as the autopilot's own filters see it, before the errors of its sensors: the truth, unless it estimates.
  virtual const VehicleState& estimated() const { return state(); }
  /// Roll, pitch, yaw of the true state, in rad.
  virtual core::Euler<double> attitude() const { return core::euler_of(state().rotation_wb); }

 protected:
  VehiclePort() = default;
  ~VehiclePort() = default;
};

}  // namespace m100::sim
