// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "host_tests/sim/autopilot/n1_behaviour.h"
#include "host_tests/sim/autopilot/n1_event_log.h"
#include "host_tests/sim/world/vehicle_port.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/telemetry.h"

namespace m100::sim {

/// Take-off and landing. A task flies level, by the autopilot's own attitude hold [inferred], whoever has control of
/// the sticks.
class N1Task {
 public:
  N1Task(const N1EventLog& log, VehiclePort& vehicle, const N1Behaviour::Tasks& how)
      : log_(log), vehicle_(vehicle), how_(how) {}

  /// @param value of N1EventKind::kTasks
  void set_behaviour(double value) { behaviour_ = value; }
  /// The client's commands. @returns the code of the answer.
  std::uint16_t start(const protocol::TaskRequest& request, bool client_in_control);
  std::uint16_t result(const protocol::TaskQuery& query) const;

  bool in_progress() const { return open_ && !done_; }
  /// One tick of a task in progress.
  MovementInput fly();
  void end();
  /// Ends a task in progress if the pilot, or no device, has control [inferred].
  void end_with_control() {
    if (how_.end_with_control) {
      end();
    }
  }
  void restart();
  protocol::FlightStatus flight_status() const;

 private:
  const N1EventLog& log_;
  VehiclePort& vehicle_;
  const N1Behaviour::Tasks& how_;
  double behaviour_ = 1.0;
  protocol::Task task_{};
  bool open_ = false;
  bool done_ = false;
  std::uint8_t number_ = 0;
  core::TimePoint landed_at_{};  ///< the epoch: never
};

}  // namespace m100::sim
