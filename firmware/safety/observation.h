// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/time.h"
#include "firmware/safety/limits.h"

namespace m100::safety {

/// What the supervisor is told in a tick: plain numbers. Which signs they are is decided by Limits.
struct Observation {
  core::TimePoint now{};
  core::Duration pose_age{core::Duration::max()};       ///< of the newest pose that the estimate used
  core::Duration telemetry_age{core::Duration::max()};  ///< since the newest frame of the autopilot
  MeasuredLatency pose_latency{};                       ///< as measured in flight; decides what counts as fresh
  std::uint32_t refused_poses = 0;                      ///< by the innovation gate, in a row
  core::Duration refused_for{0};                        ///< from the first to the last that agree with each other
  double refused_by_m = 0.0;  ///< the last of them, from where it had to be; and what was allowed
  double refused_allowed_m = 0.0;
  double error_m = 0.0;     ///< three sigmas of the predicted position, on the axis that is worse
  double reserve_m = 1e6;   ///< between where the aircraft can stop and the nearest side of its fence
  double outside_m = -1e6;  ///< how far the estimated place is beyond the nearest side of the fence; negative: inside
  double speed_m_s = 0.0;   ///< horizontal, by the estimate; 0 where it is worth nothing
  /// What it will be when the sticks are the pilot's, if they go back now and what makes it grow goes on; not less.
  double speed_then_m_s = 0.0;
  core::Duration place_lost_for{0};  ///< since when the wind has kept the aircraft from its place
  double push_m_s2 = 0.0;            ///< of that wind, averaged over 2 s
  double swing_rad = 0.0;            ///< of the tilt by itself, from trough to crest, when it was last noticed
  double swing_hz = 0.0;             ///< its frequency
  bool swings = false;               ///< it was noticed in this flight, and a calm law flies since
  bool swings_on = false;            ///< under the calm law, too
  double refused_turn_rad = 0.0;     ///< from the heading that it had to have
  /// The check (est::Check; 0: none) by which the autopilot's telemetry contradicts the poses, which are then refused:
  /// refused_for is at least Limits::gate_shut. By how much, and what is allowed, in its own unit.
  std::uint8_t contradicted_by = 0;
  double contradicted_with = 0.0;
  double contradicted_allowed = 0.0;
  bool estimate_healthy = false;     ///< est::Estimate::healthy
  bool authority = false;            ///< the autopilot says that we command
  bool mode_f = false;               ///< the pilot's switch stands at F
  bool operator_engages = false;     ///< the operator's order to fly stands: for FlightConfig::order_lasts at most
  bool operator_releases = false;    ///< the operator gives control back, this tick
  bool task_flies = false;           ///< the autopilot takes off or lands by its own task, by the operator's order
  std::array<bool, 4> left_model{};  ///< roll, pitch, yaw rate, climb: reality left the model
  bool trim_drifted = false;         ///< a balancing point is not where the vehicle file has it
};

}  // namespace m100::safety
