// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/time.h"

namespace m100::safety {

/// What the supervisor is told in a tick. Plain observations; what they mean is decided by Limits and the table.
struct Facts {
  core::TimePoint now{};
  core::Duration pose_age{core::Duration::max()};       ///< of the newest pose that the estimate used
  core::Duration telemetry_age{core::Duration::max()};  ///< since the newest frame of the autopilot
  std::uint32_t refused_poses = 0;                      ///< by the innovation gate, in a row
  bool estimate_healthy = false;                        ///< initialised, finite, covariance inside its limits
  bool authority = false;                               ///< the autopilot says that we command
  bool mode_f = false;                                  ///< the pilot's switch stands at F
  bool operator_engages = false;                        ///< the operator asks (again) for automatic flight, this tick
  bool operator_releases = false;                       ///< the operator gives control back, this tick
  std::array<bool, 4> left_model{};                     ///< roll, pitch, yaw rate, climb: reality left the model
  bool trim_drifted = false;                            ///< a balancing point is not where the vehicle file has it
};

/// The named timers and counts of the ladder.
struct Limits {
  core::Duration pose_fresh = std::chrono::milliseconds(60);
  core::Duration coast = std::chrono::milliseconds(200);
  core::Duration level = std::chrono::milliseconds(1000);
  core::Duration neutral = std::chrono::milliseconds(500);
  core::Duration telemetry_stale = std::chrono::milliseconds(100);
  core::Duration telemetry_dead = std::chrono::milliseconds(500);
  std::uint32_t gate_shut_poses = 5;
  std::uint32_t good_ticks_to_recover = 10;
};

/// What each command may be, and how fast it may change.
struct Envelope {
  double tilt_rad = 0.4363323129985824;  ///< 25 deg, the MPC's own box
  double tilt_slew_rad_s = 20.0;
  double climb_m_s = 2.0;
  double climb_slew_m_s2 = 40.0;
  double yaw_rate_rad_s = 1.7453292519943295;  ///< 100 deg/s (protocol, 6.4)
  double yaw_slew_rad_s2 = 40.0;
};

}  // namespace m100::safety
