// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"

namespace m100::est {

/// Whether poses and autopilot agree, and the speed that follows from those of them that are right.
struct ConsistencyStatus {
  std::uint32_t refused_poses = 0;  ///< by the innovation gate, in a row
  core::Duration refused_for{0};    ///< from the first to the last that agree with each other
  double refused_by_m = 0.0;        ///< distance of the last refused pose from its expected place
  double refused_allowed_m = 0.0;   ///< distance that was allowed
  double refused_turn_rad = 0.0;    ///< of the last refused pose, from its expected heading
  double speed_m_s = 0.0;           ///< horizontal; 0 if nothing shall wait for it: it is unknown, or a limit cycle
  /// Predicted speed when the pilot has the sticks, if they go back now and the acceleration continues; >= speed_m_s.
  double speed_then_m_s = 0.0;
  /// The check (est::ConsistencyCheck; 0: none) by which the autopilot's telemetry contradicts the poses, which are
  /// then refused: refused_for is at least Limits::gate_shut. The next two are the contradiction and its limit, in the
  /// check's unit.
  std::uint8_t contradicted_by = 0;
  double contradicted_with = 0.0;
  double contradicted_allowed = 0.0;
};

}  // namespace m100::est
