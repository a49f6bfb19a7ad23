// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "firmware/core/time.h"
#include "host_tests/sim/autopilot/n1_behaviour.h"
#include "host_tests/sim/autopilot/n1_client_record.h"
#include "host_tests/sim/world/vehicle_port.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/telemetry.h"

namespace m100::sim {

/// Virtual RC: the channels that replace the transmitter's while it is on. It ends one second after its last data.
class N1VirtualRc {
 public:
  N1VirtualRc(const N1EventLog& log, N1ClientRecord& record, const N1Behaviour::VirtualRc& how)
      : log_(log), record_(record), how_(how) {}

  bool is_on() const { return on_; }
  /// @param may_begin the transmitter is in mode F, outside of which Virtual RC cannot begin [inferred], and the client
  /// has control if that is needed.
  void switch_to(const protocol::VirtualRcSwitch& wanted, bool may_begin);
  void update(const protocol::VirtualRcData& data);
  /// Why it ends now, because its data are late; empty: it does not.
  std::string_view late() const;
  /// @returns whether it was on.
  bool end(std::string_view why);
  void restart() { on_ = false; }

  StickInput sticks() const;
  /// The RC item of telemetry that shows these channels.
  protocol::Telemetry::Rc rc_item() const;

 private:
  const N1EventLog& log_;
  N1ClientRecord& record_;
  const N1Behaviour::VirtualRc& how_;
  bool on_ = false;
  bool falls_back_ = true;
  core::TimePoint last_data_{};
  protocol::VirtualRcData data_;
};

}  // namespace m100::sim
