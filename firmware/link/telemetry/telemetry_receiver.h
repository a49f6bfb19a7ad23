// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/time.h"
#include "firmware/link/link_meter.h"
#include "firmware/link/telemetry/telemetry_clock.h"
#include "protocol/dji/telemetry.h"
#include "protocol/dji/telemetry_layout.h"

namespace m100::link {

/// Turns telemetry packages into the newest value of every item and the time of its arrival. Repeated and overtaken
/// packages are not used; a number that is not finite leaves its item as it was.
class TelemetryReceiver {
 public:
  /// What a package was.
  struct Reception {
    bool is_old = false;      ///< repeated, overtaken, or the first of a new clock
    bool restarted = false;   ///< its clock is a new one: the autopilot restarted
    std::uint16_t items = 0;  ///< those that were used
  };

  /// Begins a tick, in which no item has come yet.
  void begin() { telemetry_.items = 0; }
  /// @param last when the line was read before: the package came between then and `now`, so that a stall of our own is
  ///   not taken for a restart. @param waited the package may have waited in the parser: it is not used for delays.
  Reception take(std::span<const std::byte> package, bool waited, core::TimePoint last, core::TimePoint now,
                 LinkMeter& meter);
  /// For another autopilot at the other end: nothing counts as received, and the layout is the M100's again.
  void reset();
  void set_layout(protocol::TelemetryLayout layout) { layout_ = layout; }

  const protocol::Telemetry& telemetry() const { return telemetry_; }
  protocol::TelemetryLayout layout() const { return layout_; }
  /// When the item last came; the epoch if never.
  core::TimePoint received_at(protocol::TelemetryItem item) const;
  bool recent(protocol::TelemetryItem item, core::TimePoint now, core::Duration age) const {
    return (seen_items_ & static_cast<std::uint16_t>(item)) != 0 && now - received_at(item) <= age;
  }

 private:
  protocol::Telemetry telemetry_;
  protocol::TelemetryLayout layout_ = protocol::TelemetryLayout::kM100;
  std::array<core::TimePoint, protocol::kTelemetryItemCount> item_times_{};
  std::uint16_t seen_items_ = 0;
  TelemetryClock clock_;
};

}  // namespace m100::link
