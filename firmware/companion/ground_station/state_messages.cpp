// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/state_messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace m100::companion {
namespace {

// Numbers of MAVLink's common message set.
constexpr std::uint8_t kQuadrotor = 2;       // MAV_TYPE
constexpr std::uint8_t kCustomModeFlag = 1;  // MAV_MODE_FLAG
constexpr std::uint8_t kGuidedFlag = 8;
constexpr std::uint8_t kArmedFlag = 128;
constexpr std::uint8_t kStandby = 3;  // MAV_STATE
constexpr std::uint8_t kActive = 4;
constexpr std::uint8_t kCritical = 5;
constexpr std::uint8_t kEmergency = 6;
constexpr std::uint16_t kEstimateFlags =
    1 | 2 | 4 | 16 | 32;  // attitude, velocities, positions: ESTIMATOR_STATUS_FLAGS
constexpr std::uint16_t kPredictedFlag = 512;
constexpr std::uint8_t kWarning = 4;  // MAV_SEVERITY
constexpr std::uint8_t kInformation = 6;
constexpr std::uint8_t kProtocolVersion = 3;

std::uint32_t milliseconds(core::TimePoint now) {
  return static_cast<std::uint32_t>(now.time_since_epoch().count() / 1000);
}

std::uint8_t system_status(const app::TickRecord<double>& record) {
  switch (record.supervised.failsafe_state) {
    case safety::FailsafeState::kNominal:
      return kActive;
    case safety::FailsafeState::kLevel:
      return record.seen.orders.task_flies ? kActive : kCritical;
    case safety::FailsafeState::kCoast:
      return kCritical;
    case safety::FailsafeState::kRelease:
      return kEmergency;
    case safety::FailsafeState::kSilent:
      break;
  }
  return kStandby;
}

}  // namespace

mavlink::Heartbeat heartbeat_of(const app::TickRecord<double>& record) {
  const safety::FailsafeState state = record.supervised.failsafe_state;
  return {.custom_mode = static_cast<std::uint32_t>(state),
          .type = kQuadrotor,
          .autopilot = 0,
          .base_mode = static_cast<std::uint8_t>(kCustomModeFlag | (record.authority.in_control ? kArmedFlag : 0) |
                                                 (state != safety::FailsafeState::kSilent ? kGuidedFlag : 0)),
          .system_status = system_status(record),
          .mavlink_version = kProtocolVersion};
}

mavlink::AttitudeQuaternion attitude_of(const app::TickRecord<double>& record) {
  const double turn_rad = record.source_frame.turn_rad();
  const core::Vector<double, 2> tilt =
      core::rotate_by_yaw<double>({record.estimate.x.tilt_rad, -record.estimate.y.tilt_rad}, -turn_rad);
  const core::Quaternion<double> q = core::flip_yz(core::quaternion_of(core::attitude_of(
      core::Tilt<double>{.x_rad = tilt.x(), .y_rad = -tilt.y()}, core::wrap_pi(record.estimate.yaw_rad - turn_rad))));
  const std::array<float, 3>& rate_frd_rad_s = record.telemetry.angular_velocity_frd_rad_s;
  return {.time_boot_ms = milliseconds(record.now),
          .q1 = static_cast<float>(q.w),
          .q2 = static_cast<float>(q.x),
          .q3 = static_cast<float>(q.y),
          .q4 = static_cast<float>(q.z),
          .rollspeed = rate_frd_rad_s[0],
          .pitchspeed = rate_frd_rad_s[1],
          .yawspeed = rate_frd_rad_s[2],
          .repr_offset_q = {}};
}

mavlink::LocalPositionNed position_of(const app::TickRecord<double>& record) {
  const est::Estimate<double>& flown = record.estimate;
  const core::Vector<double, 3> position_m(flown.x.position_m, flown.y.position_m, flown.height_m);
  const core::Vector<double, 3> velocity_m_s(flown.x.velocity_m_s, flown.y.velocity_m_s, flown.climb_m_s);
  const core::Vector<double, 3> at = record.source_frame.to_source(position_m);
  const core::Vector<double, 3> v = record.source_frame.to_source(position_m + velocity_m_s) - at;
  return {.time_boot_ms = milliseconds(record.now),
          .x = static_cast<float>(at.x()),
          .y = static_cast<float>(-at.y()),
          .z = static_cast<float>(-at.z()),
          .vx = static_cast<float>(v.x()),
          .vy = static_cast<float>(-v.y()),
          .vz = static_cast<float>(-v.z())};
}

mavlink::EstimatorStatus estimator_of(const app::TickRecord<double>& record) {
  const est::Estimate<double>& at = record.estimate;
  const est::ConsistencyStatus& seen = record.seen.consistency;
  const bool is_refused = seen.refused_poses > 0 && seen.refused_allowed_m > 0.0;
  return {.time_usec = static_cast<std::uint64_t>(record.now.time_since_epoch().count()),
          .pos_horiz_ratio = static_cast<float>(is_refused ? seen.refused_by_m / seen.refused_allowed_m : 0.0),
          .pos_horiz_accuracy =
              static_cast<float>(std::sqrt(std::max({0.0, at.x.position_variance_m2, at.y.position_variance_m2}))),
          .flags = static_cast<std::uint16_t>((at.healthy ? kEstimateFlags : 0) |
                                              (at.prediction_valid || at.healthy ? kPredictedFlag : 0))};
}

mavlink::BatteryStatus battery_of(const app::TickRecord<double>& record) {
  const protocol::Telemetry& telemetry = record.telemetry;
  mavlink::BatteryStatus message{
      .current_consumed = -1,
      .energy_consumed = -1,
      .temperature = std::numeric_limits<std::int16_t>::max(),
      .current_battery = -1,
      .battery_remaining = static_cast<std::int8_t>(telemetry.has(protocol::TelemetryItem::kBattery)
                                                        ? std::min<std::uint8_t>(telemetry.battery_percent, 100)
                                                        : -1)};
  message.voltages.fill(std::numeric_limits<std::uint16_t>::max());
  return message;
}

bool status_text(std::string_view sentence, std::uint8_t severity, std::uint16_t id, std::uint8_t piece,
                 mavlink::StatusText& message) {
  constexpr std::size_t kPiece = std::tuple_size_v<decltype(mavlink::StatusText::text)>;
  const std::size_t begin = kPiece * piece;
  // A piece that is not full marks the end for the receiver.
  const bool exists = begin < sentence.size() || (piece > 0 && begin == sentence.size());
  if (!exists) {
    return false;
  }
  const std::string_view part = sentence.substr(begin, kPiece);
  message = {.severity = severity,
             .text = {},
             .id = sentence.size() > kPiece ? id : std::uint16_t{0},
             .chunk_seq = sentence.size() > kPiece ? piece : std::uint8_t{0}};
  std::copy(part.begin(), part.end(), message.text.begin());
  return sentence.size() > kPiece || piece == 0;
}

std::uint8_t severity_of(std::string_view line) { return line.starts_with("failsafe:") ? kWarning : kInformation; }

}  // namespace m100::companion
