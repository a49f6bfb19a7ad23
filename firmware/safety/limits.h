// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/time.h"

namespace m100::safety {

/// Latency of the poses from capture to arrival, as est::PoseTiming measured it in flight.
struct MeasuredLatency {
  core::Duration min_latency{0};
  core::Duration jitter{0};    ///< 99th percentile of the latency minus min_latency
  core::Duration interval{0};  ///< between two captures
};

/// The limits of the failsafe: times, a number of poses and a speed.
struct Limits {
  core::Duration pose_fresh = std::chrono::milliseconds(60);
  /// Whether the flight file sets pose_fresh; then the measured latency does not lengthen the limit.
  bool pose_fresh_is_set = false;
  core::Duration coast = std::chrono::milliseconds(700);
  core::Duration level = std::chrono::milliseconds(1000);
  /// LEVEL lasts longer than `level` while the aircraft is faster than hand_over_m_s, so that the pilot gets it slow:
  /// at most level_moving while the speed is predicted, and level_moving_seen while a fresh pose shows it.
  core::Duration level_moving = std::chrono::milliseconds(2500);
  core::Duration level_moving_seen = std::chrono::milliseconds(10000);
  double hand_over_m_s = 0.9;
  core::Duration neutral = std::chrono::milliseconds(500);
  core::Duration telemetry_stale = std::chrono::milliseconds(100);
  core::Duration telemetry_dead = std::chrono::milliseconds(500);
  core::Duration gate_shut = std::chrono::milliseconds(300);            ///< of refused poses that agree: estimate lost
  core::Duration authority_exceeded = std::chrono::milliseconds(3000);  ///< the wind is stronger than the aircraft
  core::Duration on_ground = std::chrono::milliseconds(500);            ///< promise R18
  std::uint32_t good_poses_to_recover = 10;
};

inline constexpr core::Duration kFreshMargin = std::chrono::milliseconds(10);
inline constexpr core::Duration kMaxFresh = std::chrono::milliseconds(250);

/// Largest age of a pose in normal flight (promise R3). If the flight file sets pose_fresh, it is that. Otherwise it is
/// the larger of pose_fresh and the limit that the measured latency requires, which is at most 250 ms.
constexpr core::Duration fresh_limit(const Limits& limits, const MeasuredLatency& measured) {
  const core::Duration needed = measured.min_latency + 2 * measured.jitter + measured.interval + kFreshMargin;
  if (limits.pose_fresh_is_set || needed <= limits.pose_fresh) {
    return limits.pose_fresh;
  }
  return needed < kMaxFresh ? needed : kMaxFresh;
}

/// Whether vibration is so strong that nothing tells a false pose. The check of the force allows three sigmas of what
/// vibration leaves in its sum: at this limit a false motion of 2.7 m/s is hidden. A lower limit would end hovers with
/// a broken propeller, 8 m/s^2 at 100 Hz, that fly well. @param velocity_sigma_m_s est::VibrationStatus
constexpr bool hides_false_poses(const Limits& limits, double velocity_sigma_m_s) {
  return velocity_sigma_m_s >= limits.hand_over_m_s;
}

/// Range and slew limit of each command.
template <typename T>
struct EnvelopeIn {
  /// Limit of the tilt of both axes together: 30 deg, as the law's own limit.
  T tilt_rad = T(0.5235987755982988);
  T tilt_slew_rad_s = T(20.0);
  T climb_m_s = T(2.0);
  T climb_slew_m_s2 = T(40.0);
  T yaw_rate_rad_s = T(1.7453292519943295);  ///< 100 deg/s (protocol, 6.4)
  T yaw_slew_rad_s2 = T(40.0);

  template <typename Other>
  EnvelopeIn<Other> cast() const {
    return {.tilt_rad = static_cast<Other>(tilt_rad),
            .tilt_slew_rad_s = static_cast<Other>(tilt_slew_rad_s),
            .climb_m_s = static_cast<Other>(climb_m_s),
            .climb_slew_m_s2 = static_cast<Other>(climb_slew_m_s2),
            .yaw_rate_rad_s = static_cast<Other>(yaw_rate_rad_s),
            .yaw_slew_rad_s2 = static_cast<Other>(yaw_slew_rad_s2)};
  }
};
using Envelope = EnvelopeIn<double>;

}  // namespace m100::safety
