// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/time.h"
#include "firmware/safety/flight_failure.h"
#include "firmware/safety/limits.h"

namespace m100::safety {

/// Inputs of the supervisor in one tick: plain numbers. The supervisor turns them into signs by its Limits.
struct Observation {
  core::TimePoint now{};
  core::Duration pose_age{core::Duration::max()};       ///< of the newest pose that the estimate used
  core::Duration telemetry_age{core::Duration::max()};  ///< since the newest frame of the autopilot
  MeasuredLatency pose_latency{};                       ///< as measured in flight; decides what counts as fresh
  std::uint32_t refused_poses = 0;                      ///< by the innovation gate, in a row
  core::Duration refused_for{0};                        ///< from the first to the last that agree with each other
  double refused_by_m = 0.0;                            ///< distance of the last refused pose from its expected place
  double refused_allowed_m = 0.0;                       ///< distance that was allowed
  double error_m = 0.0;                                 ///< three sigmas of the predicted position, on the worse axis
  double reserve_m = 1e6;   ///< from the point where the aircraft can stop to the nearest side of its fence
  double outside_m = -1e6;  ///< how far the estimated place is beyond the nearest side of the fence; negative: inside
  double speed_m_s = 0.0;   ///< horizontal, by the estimate; 0 if the estimate is useless
  /// Predicted speed when the pilot has the sticks, if they go back now and the acceleration continues; >= speed_m_s.
  double speed_then_m_s = 0.0;
  core::Duration authority_exceeded_for{0};    ///< how long the wind has kept the aircraft from its place
  double disturbance_acceleration_m_s2 = 0.0;  ///< of that wind, averaged over 2 s
  double limit_cycle_rad = 0.0;       ///< the aircraft's own tilt oscillation, trough to crest, when last noticed
  double limit_cycle_hz = 0.0;        ///< its frequency
  bool limit_cycle_detected = false;  ///< it was noticed in this flight, and the calm law flies since then
  bool limit_cycle_persists = false;  ///< it continues under the calm law
  double refused_turn_rad = 0.0;      ///< of the last refused pose, from its expected heading
  /// The check (est::Check; 0: none) by which the autopilot's telemetry contradicts the poses, which are then refused:
  /// refused_for is at least Limits::gate_shut. The next two are the contradiction and its limit, in the check's unit.
  std::uint8_t contradicted_by = 0;
  double contradicted_with = 0.0;
  double contradicted_allowed = 0.0;
  bool estimate_healthy = false;   ///< est::Estimate::healthy
  bool authority = false;          ///< the autopilot says that we command
  bool mode_f = false;             ///< the pilot's switch stands at F
  bool operator_engages = false;   ///< the operator's order to fly stands: for FlightConfig::order_timeout at most
  bool operator_releases = false;  ///< the operator gives control back, this tick
  /// In flight: how long the autopilot's flight status has said "on the ground"; zero: it says otherwise, or nothing.
  core::Duration on_ground_for{0};
  FlightFailure failure = FlightFailure::kNone;  ///< by FailureDetector
  bool task_flies = false;               ///< the autopilot takes off or lands by its own task, by the operator's order
  std::array<bool, 4> model_mismatch{};  ///< roll, pitch, yaw rate, climb: the axis no longer follows its model
  bool trim_drifted = false;             ///< a balancing point differs from the vehicle file
};

}  // namespace m100::safety
