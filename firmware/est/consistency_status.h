// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"

namespace m100::est {

/// Whether poses and autopilot agree, and the speed by whichever of the two is right.
struct ConsistencyStatus {
  std::uint32_t refused_poses = 0;  ///< by the innovation gate, in a row
  core::Duration refused_for{0};    ///< from the first to the last that agree with each other
  double refused_by_m = 0.0;        ///< distance of the last refused pose from its expected place
  double refused_allowed_m = 0.0;   ///< distance that was allowed
  double refused_turn_rad = 0.0;    ///< of the last refused pose, from its expected heading
  double speed_m_s = 0.0;           ///< horizontal; 0 (nothing waits for braking) if it is unknown or a limit cycle
  /// In kLevel: speed when the pilot gets the sticks, if released now at a constant acceleration; >= speed_m_s. Else 0.
  double speed_then_m_s = 0.0;
  /// The check (est::ConsistencyCheck; 0: none) by which the autopilot's telemetry contradicts the poses, which are
  /// then refused: refused_for is at least Limits::gate_shut. The next two are its residual and limit, in its unit.
  std::uint8_t contradicted_by = 0;
  double contradicted_with = 0.0;
  double contradicted_allowed = 0.0;
};

}  // namespace m100::est
