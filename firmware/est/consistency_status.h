// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/time.h"

namespace m100::est {

/// The vibration in the specific force (est::Vibration).
struct VibrationStatus {
  double rms_m_s2 = 0.0;   ///< of one axis, above 15 Hz; not a number: telemetry is too slow to see 15 Hz
  double peak_m_s2 = 0.0;  ///< of one axis, fading
  double clipped = 0.0;    ///< share of the messages at the end of the sensor's range
  /// One sigma of an axis of the velocity that the check of the force compares, by the vibration alone.
  double velocity_sigma_m_s = 0.0;
};

/// Whether poses and autopilot contradict each other, and the horizontal speed by the channel that is trusted.
struct ConsistencyStatus {
  std::uint32_t refused_poses = 0;  ///< by the innovation gate, in a row
  /// How long poses have been refused; at least Limits::gate_shut while the motion counts as false.
  core::Duration refused_for{0};
  double refused_by_m = 0.0;       ///< distance of the last refused pose from the expected one, on the worst axis
  double refused_allowed_m = 0.0;  ///< gate on that axis
  double refused_turn_rad = 0.0;   ///< of the last refused pose, from its expected heading
  double speed_m_s = 0.0;          ///< horizontal; 0 if it is unknown, or while a limit cycle persists
  /// Predicted horizontal speed at the hand-over if control is given back from now on. 0 outside kLevel or in a limit
  /// cycle.
  double speed_then_m_s = 0.0;
  /// The est::ConsistencyCheck that contradicts the poses or the attitude; 0: none. The next two numbers are its
  /// residual and limit, in its unit.
  std::uint8_t contradicted_by = 0;
  double contradicted_with = 0.0;
  double contradicted_allowed = 0.0;
  VibrationStatus vibration{};
  std::array<double, 3> lever_b_m{};  ///< that explains the difference, forward, left, up; zero: none does
};

}  // namespace m100::est
