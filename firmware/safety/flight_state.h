// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/core/time.h"

namespace m100::safety {

/// A state of the aircraft that no command of ours ends.
enum class FlightFailure : std::uint8_t {
  kNone,
  kTilt,      ///< tilted beyond 45 degrees
  kTumbling,  ///< turned by 90 degrees at more than one revolution per second
  kFreeFall,  ///< almost no specific force for 0.3 s, while it sinks
  kCrash,     ///< tilted 30 degrees away from the predicted tilt for 2 s, or a shock and then no motion
};

std::string_view name(FlightFailure failure);

/// Whether the aircraft still flies.
struct FlightState {
  /// How long the status has been "on the ground" (GroundContact). 0 before it was ever "in the air", and again once it
  /// has been "in the air" for 1.5 s.
  core::Duration on_ground_for{0};
  FlightFailure failure = FlightFailure::kNone;  ///< by FailureDetector
};

}  // namespace m100::safety
