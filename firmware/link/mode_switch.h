// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"
#include "protocol/dji/telemetry.h"

namespace m100::link {

/// The pilot's mode switch. While Virtual RC is on, the RC item may show our own mode channel (A) instead of the real
/// switch (protocol, 7); then only the loss of control in the control item shows that the switch has left F. An RC item
/// that shows F after we have sent mode A for kOwnModeShows shows the real switch.
class ModeSwitch {
 public:
  /// If the RC item can show our own mode (A), it does so at most this long after our first Virtual RC data.
  static constexpr core::Duration kOwnModeShows = std::chrono::milliseconds(200);

  /// A command was sent.
  void sent(core::TimePoint now) {
    first_command_ = commanded_ ? first_command_ : now;
    commanded_ = true;
  }
  /// Control is not ours.
  void end_commands() { commanded_ = false; }
  /// After each telemetry package. @param items those that it brought.
  void update(const protocol::Telemetry& telemetry, std::uint16_t items, core::TimePoint now) {
    const bool ours_would_show = commanded_ && now - first_command_ >= kOwnModeShows;
    const bool has_rc = (items & static_cast<std::uint16_t>(protocol::TelemetryItem::kRc)) != 0;
    rc_item_is_real_ =
        rc_item_is_real_ || (has_rc && ours_would_show && telemetry.control.virtual_rc_on() && shows_f(telemetry));
  }
  /// For another autopilot at the other end.
  void reset() { rc_item_is_real_ = false; }

  /// Whether the switch is at F, or may be because the RC item shows our own mode.
  bool is_f(const protocol::Telemetry& telemetry, bool uses_virtual_rc) const {
    const bool shows_our_mode = uses_virtual_rc && !rc_item_is_real_ && telemetry.control.virtual_rc_on() &&
                                telemetry.rc.mode == protocol::kRcModeA;
    return shows_f(telemetry) || shows_our_mode;
  }

 private:
  static bool shows_f(const protocol::Telemetry& telemetry) { return telemetry.rc.mode == protocol::kRcModeF; }

  bool commanded_ = false;  ///< a command was sent since control was granted
  core::TimePoint first_command_{};
  bool rc_item_is_real_ = false;  ///< it shows the transmitter even while Virtual RC is on
};

}  // namespace m100::link
