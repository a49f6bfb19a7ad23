// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "host_tests/sim/autopilot/n1_event_log.h"
#include "host_tests/sim/autopilot/n1_pilot.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/telemetry.h"

namespace m100::sim {

/// A stick in the RC item of telemetry.
inline std::int16_t rc_value(double counts) {
  constexpr double kFullStick = 10000.0;
  return static_cast<std::int16_t>(std::lround((counts - protocol::kStickCentre_counts) * kFullStick / 660.0));
}

/// The transmitter in the pilot's hands: its sticks, and since when they fly the aircraft.
class N1Transmitter {
 public:
  /// @param holds_position the pilot flies while he has control. Otherwise his sticks stay at rest.
  N1Transmitter(const N1EventLog& log, bool holds_position) : log_(log), holds_position_(holds_position) {}

  void set_resting(const StickInput& sticks) {
    pilot_.set_resting(sticks);
    sticks_ = sticks;
  }
  void move(const N1StickMove& move) { pilot_.move(move); }
  /// One tick. @param in_control whether its sticks fly.
  void update(bool in_control, const VehicleState& state) {
    if (in_control != (since_ != core::TimePoint::max())) {
      since_ = in_control ? log_.now() : core::TimePoint::max();
      log_.emit("did", in_control ? "transmitter_has_control" : "transmitter_lost_control");
    }
    if (in_control && holds_position_) {
      sticks_ = pilot_.fly(state, N1Clock::kTick);
    } else if (!in_control) {
      pilot_.stop();
      sticks_ = pilot_.resting();
    }
  }

  const StickInput& sticks() const { return sticks_; }
  /// Since when it has control; the latest possible time while it has not.
  core::TimePoint since() const { return since_; }
  /// The RC item of telemetry. @param mode value of its mode switch
  protocol::Telemetry::Rc rc_item(std::int16_t mode) const {
    constexpr std::int16_t kGearDown = -4545;
    return {.roll = rc_value(sticks_.roll_vrc),
            .pitch = rc_value(sticks_.pitch_vrc),
            .yaw = rc_value(sticks_.yaw_vrc),
            .throttle = rc_value(sticks_.throttle_vrc),
            .mode = mode,
            .gear = kGearDown};
  }

 private:
  const N1EventLog& log_;
  bool holds_position_;
  N1Pilot pilot_;
  StickInput sticks_;
  core::TimePoint since_{};
};

}  // namespace m100::sim
