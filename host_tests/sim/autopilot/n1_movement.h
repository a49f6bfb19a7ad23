// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"
#include "host_tests/sim/world/vehicle_port.h"
#include "protocol/dji/commands.h"

namespace m100::sim {

/// The autopilot's own control loops for movement commands (protocol, 6.4): all 14 modes, ground and body frame, flown
/// as tilt, climb and yaw rate. The gains are ours; DJI does not publish its own.
///
///   horizontal  angle: as commanded | velocity: a = (v_cmd - v) / 1 s, tilt = a / g | position: offset from the place
///               at which the command arrived, v_cmd = 0.8 (target - p), at most 5 m/s
///   vertical    velocity: as commanded | position: 1.0 (height_cmd - height) | thrust: 0.1 m/s per percent off hover
///   yaw         rate: as commanded | angle: 1.5 (angle_cmd - yaw)
class N1Movement {
 public:
  /// Takes a command whose mode exists and whose numbers protocol::check() accepts.
  void set(const protocol::Movement& movement, const VehicleState& state, core::TimePoint now);
  bool is_active() const { return active_; }
  void stop() { active_ = false; }
  /// Ends a command that is older than `timeout`. @returns whether it did.
  bool expire(core::TimePoint now, core::Duration timeout);
  /// The present command to the vehicle.
  MovementInput input(const VehicleState& state) const;
  /// The control mode of telemetry (protocol, section 8): 1..18, horizontal within vertical, yaw angle before rate.
  std::uint8_t control_mode() const {
    return static_cast<std::uint8_t>(1 + 6 * static_cast<int>(mode_.vertical) + 2 * static_cast<int>(mode_.horizontal) +
                                     static_cast<int>(mode_.yaw));
  }

 private:
  bool active_ = false;
  core::TimePoint set_at_{};
  protocol::Movement movement_;
  protocol::MovementMode mode_;
  core::Vector<double, 2> target_w_m_ = core::Vector<double, 2>::Zero();
};

}  // namespace m100::sim
