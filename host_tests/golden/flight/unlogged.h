// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <initializer_list>

#include "firmware/app/flight_controller.h"
#include "host_tests/golden/number_hash.h"

// Values that a flight computes but does not log: they enter the hash of a kept flight in addition to the log.
namespace m100::golden {

template <typename T>
void append_all(NumberHash& hash, std::initializer_list<T> numbers) {
  for (const T number : numbers) {
    hash.append(number);
  }
}

/// The observation that the supervisor judged.
inline void append(NumberHash& hash, const safety::Observation& seen) {
  append_all<double>(hash, {seen.consistency.refused_by_m, seen.consistency.refused_allowed_m, seen.estimate.error_m,
                            seen.fence.reserve_m, seen.fence.outside_m, seen.consistency.speed_m_s,
                            seen.wind.disturbance_acceleration_m_s2, seen.limit_cycle.height_rad,
                            seen.limit_cycle.frequency_hz, seen.consistency.refused_turn_rad,
                            seen.consistency.contradicted_with, seen.consistency.contradicted_allowed});
  append_all<std::int64_t>(
      hash, {seen.estimate.pose_age.count(), seen.link.telemetry_age.count(), seen.consistency.refused_for.count(),
             seen.wind.exceeded_for.count(), seen.pose_latency.min_latency.count(), seen.pose_latency.jitter.count(),
             seen.pose_latency.interval.count()});
  append_all<std::uint8_t>(
      hash, {seen.limit_cycle.detected, seen.limit_cycle.persists, seen.consistency.contradicted_by,
             seen.estimate.healthy, seen.link.in_control, seen.link.mode_f, seen.orders.engages, seen.orders.releases,
             seen.orders.task_flies, seen.model.mismatch[0], seen.model.mismatch[1], seen.model.mismatch[2],
             seen.model.mismatch[3], seen.model.trim_drifted});
}

template <typename T>
void append(NumberHash& hash, const est::Estimate<T>& estimate) {
  for (const est::AxisEstimate<T>* const axis : {&estimate.x, &estimate.y}) {
    append_all<T>(hash, {axis->position_variance_m2, axis->filter_variance_m2, axis->position_velocity_m2_s,
                         axis->velocity_variance_m2_s2});
  }
  append_all<T>(hash, {estimate.climb_m_s, estimate.yaw_rate_rad_s, estimate.refusal.distance_m,
                       estimate.refusal.allowed_m, estimate.refusal.turned_rad});
  append_all<std::uint8_t>(hash, {estimate.prediction_valid, estimate.healthy});
}

inline void append(NumberHash& hash, const link::SerialLink& link) {
  const link::LinkHealth& health = link.health();
  append_all<std::uint64_t>(
      hash, {health.packages, health.bad_packages, health.old_packages, health.refused_items, health.bytes_received,
             health.bytes_sent, health.parser.frames, health.parser.crc16_errors, health.parser.crc32_errors,
             health.parser.reserved_errors, health.parser.length_errors, health.parser.padding_errors,
             health.parser.resyncs, health.parser.bytes_dropped, health.sessions.requests, health.sessions.repeats,
             health.sessions.answers, health.sessions.failures});
  for (const std::uint32_t count : health.jitter_histogram) {
    hash.append(count);
  }
  append_all<double>(hash, {health.telemetry_rate_hz, health.receive_share, health.send_share});
  append_all<std::int64_t>(hash,
                           {health.telemetry_age.count(), health.longest_gap.count(), health.transport_delay.count()});
  hash.append(static_cast<std::uint8_t>(link.authority().reason));
}

template <typename T, typename S>
void append_counts(NumberHash& hash, const app::FlightController<T, S>& flown) {
  const est::EkfCounters counted = flown.observer_counters();
  const link::PoseLinkStats& poses = flown.pose_link().stats();
  const safety::SupervisorStats& failsafe = flown.supervisor().stats();
  append_all<std::uint64_t>(hash, {counted.poses_used,
                                   counted.poses_refused,
                                   counted.poses_stale,
                                   counted.attitudes_refused,
                                   counted.not_finite,
                                   counted.recoveries,
                                   flown.stats().stalls,
                                   flown.sensor_stats().refused_poses,
                                   flown.sensor_stats().repeated_poses,
                                   flown.sensor_stats().refused_attitudes,
                                   flown.sensor_stats().stuck_attitudes,
                                   poses.poses,
                                   poses.refused,
                                   poses.refused_order,
                                   poses.refused_senders,
                                   poses.lost_frames,
                                   poses.answers,
                                   failsafe.steps,
                                   failsafe.invalid_commands,
                                   failsafe.limited_commands,
                                   failsafe.coasts,
                                   failsafe.levels,
                                   failsafe.releases});
  hash.append(counted.nis_sum);
}

template <typename T, typename S>
void append_unlogged(NumberHash& hash, const app::FlightController<T, S>& flown) {
  append(hash, flown.observed());
  append(hash, flown.estimate());
  append(hash, flown.link());
  append_counts(hash, flown);
  for (const auto channel : {sysid::MonitoredAxis::kRoll, sysid::MonitoredAxis::kPitch, sysid::MonitoredAxis::kYawRate,
                             sysid::MonitoredAxis::kClimb}) {
    append_all(hash, {flown.residual().report(channel).ratio, flown.residual().report(channel).block_rms});
  }
  append_all<T>(hash, {flown.pose_timing().sigma_s, flown.trim().roll_counts, flown.trim().pitch_counts});
  append_all<std::int64_t>(hash, {flown.pose_timing().unreported.count(), flown.stats().longest.count()});
  hash.append(flown.pose_timing().drift);
  append_all<std::uint8_t>(hash, {flown.pose_timing().observable, flown.law().fallback(), flown.is_converged(),
                                  static_cast<std::uint8_t>(flown.supervisor().descent().reason)});
}

}  // namespace m100::golden
