// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace m100::companion {

/// The commands of the operator, or of a ground station in the operator's place, since the last call; and what else
/// decides how the FlightSequencer takes them.
struct OperatorInput {
  bool toggle_control = false;  ///< any line but "land", or SIGUSR1: takes control or gives it back
  bool land = false;            ///< the line "land", or a signed order
  std::uint32_t stops = 0;      ///< signals to end, so far
  bool backed_up = true;        ///< the second process gives control back if this program dies
  bool goal_led = false;  ///< goals have led the flight: the next one begins where the aircraft is, not at its course
};

}  // namespace m100::companion
