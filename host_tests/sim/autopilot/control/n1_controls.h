// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "host_tests/sim/autopilot/control/n1_authority.h"
#include "host_tests/sim/autopilot/control/n1_task.h"
#include "host_tests/sim/autopilot/control/n1_transmitter.h"
#include "host_tests/sim/autopilot/control/n1_virtual_rc.h"
#include "host_tests/sim/autopilot/n1_client_record.h"
#include "host_tests/sim/autopilot/n1_line.h"
#include "host_tests/sim/autopilot/n1_movement.h"

namespace m100::sim {

/// What may command the aircraft. In this order: a task, Virtual RC, movement commands, the autopilot's own hover while
/// the client has control, the transmitter.
class N1Controls {
 public:
  struct Config {
    const N1Behaviour& behaviour;
    N1Mode mode;
    bool pilot_holds_position;
  };
  /// @param config its behaviour lives as long as this object
  N1Controls(const N1EventLog& log, N1Line& line, N1ClientRecord& record, VehiclePort& vehicle, const Config& config);

  N1Authority& authority() { return authority_; }
  const N1Authority& authority() const { return authority_; }
  N1VirtualRc& virtual_rc() { return virtual_rc_; }
  const N1VirtualRc& virtual_rc() const { return virtual_rc_; }
  N1Task& task() { return task_; }
  N1Transmitter& transmitter() { return transmitter_; }
  const N1Transmitter& transmitter() const { return transmitter_; }
  /// Whether the pilot's own sticks fly: the controlling device is the transmitter, and Virtual RC does not replace it.
  bool transmitter_in_control() const {
    return authority_.device() == protocol::ControlDevice::kRemoteController && !virtual_rc_.is_on();
  }

  /// The client's commands. @returns the code of the answer.
  std::uint16_t request_control(bool obtain);
  std::uint16_t switch_motors(bool start);
  void switch_virtual_rc(const protocol::VirtualRcSwitch& wanted);
  void set_movement(const protocol::Movement& movement);

  void switch_transmitter(bool on);
  /// @param mobile the mobile app takes control; otherwise the transmitter.
  void take_control(bool mobile);
  void end_virtual_rc(std::string_view why);
  void restart();
  /// One tick: what has ended, and the command to the aircraft.
  void update();
  /// Fills the items of telemetry that show who has control.
  void report(protocol::Telemetry& telemetry) const;

 private:
  void drop_control(std::string_view why, protocol::ControlDevice now_in_control);
  void update_mode();
  MovementInput movement_input() const;

  const N1EventLog& log_;
  N1Line& line_;
  N1ClientRecord& record_;
  VehiclePort& vehicle_;
  const N1Behaviour& how_;
  N1Authority authority_;
  N1VirtualRc virtual_rc_;
  N1Movement movement_;
  N1Task task_;
  N1Transmitter transmitter_;
};

}  // namespace m100::sim
