// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"

namespace m100::est {

/// Whether poses and autopilot agree, and the speed by whichever of the two is right.
struct ConsistencyStatus {
  std::uint32_t refused_poses = 0;  ///< by the innovation gate, in a row
  core::Duration refused_for{0};    ///< how long poses have been refused, see FaultIsolation::status()
  double refused_by_m = 0.0;        ///< distance of the last refused pose from the expected one, on the worst axis
  double refused_allowed_m = 0.0;   ///< gate on that axis
  double refused_turn_rad = 0.0;    ///< of the last refused pose, from its expected heading
  double speed_m_s = 0.0;           ///< horizontal; 0 (nothing waits for braking): unknown, or a limit cycle persists
  /// In kLevel without a limit cycle: speed at the hand-over, if released now, by the present acceleration. Else 0.
  double speed_then_m_s = 0.0;
  /// The check (est::ConsistencyCheck; 0: none) that contradicts the poses or the attitude: refused_for is then at
  /// least Limits::gate_shut. The next two are its residual and limit, in its unit.
  std::uint8_t contradicted_by = 0;
  double contradicted_with = 0.0;
  double contradicted_allowed = 0.0;
};

}  // namespace m100::est
