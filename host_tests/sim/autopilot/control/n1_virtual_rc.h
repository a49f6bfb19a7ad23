// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "firmware/core/time.h"
#include "host_tests/sim/autopilot/n1_client_record.h"
#include "host_tests/sim/world/vehicle_port.h"
#include "protocol/dji/commands.h"
#include "protocol/dji/telemetry.h"

namespace m100::sim {

/// Virtual RC: the channels that replace the transmitter's while it is on. It ends one second after its last data.
class N1VirtualRc {
 public:
  /// @param lenient accepts data under the on/off id. @param timeout from the last data to the end.
  N1VirtualRc(const N1EventLog& log, N1ClientRecord& record, bool lenient, core::Duration timeout)
      : log_(log), record_(record), lenient_(lenient), timeout_(timeout) {}

  bool is_on() const { return on_; }
  /// @param rc_in_f the transmitter is in mode F, outside of which Virtual RC cannot begin [inferred].
  void switch_to(const protocol::VirtualRcSwitch& wanted, bool rc_in_f);
  void update(const protocol::VirtualRcData& data);
  /// Ends it if its data are late.
  void expire();
  void end(std::string_view why);
  void restart() { on_ = false; }

  StickInput sticks() const;
  /// The RC item of telemetry that shows these channels.
  protocol::Telemetry::Rc rc_item() const;

 private:
  const N1EventLog& log_;
  N1ClientRecord& record_;
  bool lenient_;
  core::Duration timeout_;
  bool on_ = false;
  bool falls_back_ = true;
  core::TimePoint last_data_{};
  protocol::VirtualRcData data_;
};

}  // namespace m100::sim
