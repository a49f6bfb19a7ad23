// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "firmware/core/time.h"
#include "protocol/dji/telemetry.h"

namespace m100::companion {

/// Shows that the autopilot lands, by the flight status item of telemetry: at a low battery it does so by itself, and
/// ignores the sticks. No heap.
class LandingMonitor {
 public:
  static constexpr core::Duration kConfirmed = std::chrono::milliseconds(500);  ///< six items in a row, at 10 Hz

  /// Call it in each tick. @param received_at of the newest item, whose status this is. It counts from the first item
  /// to the last that say so, so that a gap of telemetry proves nothing.
  void update(protocol::FlightStatus status, core::TimePoint received_at) {
    const bool says_so = status == protocol::FlightStatus::kLanding;
    first_ = says_so ? first_.value_or(received_at) : std::optional<core::TimePoint>{};
    newest_ = received_at;
  }
  bool lands() const { return first_ && newest_ - *first_ >= kConfirmed; }

 private:
  core::TimePoint newest_{};
  std::optional<core::TimePoint> first_;  ///< of the items that say "landing" in a row
};

}  // namespace m100::companion
