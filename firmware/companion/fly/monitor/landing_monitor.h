// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/link/serial_link.h"

namespace m100::companion {

/// Shows that the autopilot lands, by the flight status item of telemetry: at a low battery it does so by itself, and
/// ignores the sticks. No heap.
class LandingMonitor {
 public:
  static constexpr core::Duration kConfirmed = std::chrono::milliseconds(500);  ///< five items in a row, at 10 Hz

  /// Call it in each tick. It counts from item to item, so that a gap of telemetry proves nothing.
  void update(const link::SerialLink& link) {
    newest_ = link.received_at(protocol::TelemetryItem::kFlightStatus);
    before_ = link.telemetry().flight_status == protocol::FlightStatus::kLanding ? before_ : newest_;
  }
  bool lands() const { return newest_ - before_ >= kConfirmed; }

 private:
  core::TimePoint newest_{};
  core::TimePoint before_{};  ///< of the last item with another status
};

}  // namespace m100::companion
