// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/ground_station/state_messages.h"

#include <algorithm>
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

float ned(const std::array<double, 3>& world, std::size_t axis) {
  return static_cast<float>(axis == 0 ? world[axis] : -world[axis]);
}

std::uint8_t system_status(const FlightState& state) {
  switch (state.failsafe_state) {
    case safety::FailsafeState::kNominal:
      return kActive;
    case safety::FailsafeState::kLevel:
      return state.task_flies ? kActive : kCritical;
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

FlightState state_of(const app::FlightController<double>& controller, core::TimePoint now) {
  const est::Estimate<double>& estimate = controller.estimate();
  const app::SourceFrame<double>& source = controller.source_frame();
  const core::Vector<double, 3> position_m(estimate.x.position_m, estimate.y.position_m, estimate.height_m);
  const core::Vector<double, 3> velocity_m_s(estimate.x.velocity_m_s, estimate.y.velocity_m_s, estimate.climb_m_s);
  const core::Vector<double, 3> at = source.to_source(position_m);
  const core::Vector<double, 3> v = source.to_source(position_m + velocity_m_s) - at;
  const core::Vector<double, 2> tilt =
      core::rotate_by_yaw<double>({estimate.x.tilt_rad, -estimate.y.tilt_rad}, -source.turn_rad());
  const protocol::Telemetry& telemetry = controller.link().telemetry();
  const safety::Observation& seen = controller.observed();
  const bool is_refused = seen.consistency.refused_poses > 0 && seen.consistency.refused_allowed_m > 0.0;
  return {.now = now,
          .position_w_m = {at.x(), at.y(), at.z()},
          .velocity_w_m_s = {v.x(), v.y(), v.z()},
          .tilt = {.x_rad = tilt.x(), .y_rad = -tilt.y()},
          .yaw_rad = core::wrap_pi(estimate.yaw_rad - source.turn_rad()),
          .rate_frd_rad_s = telemetry.angular_velocity_frd_rad_s,
          .horizontal_sigma_m =
              std::sqrt(std::max({0.0, estimate.x.position_variance_m2, estimate.y.position_variance_m2})),
          .gate_ratio = is_refused ? seen.consistency.refused_by_m / seen.consistency.refused_allowed_m : 0.0,
          .healthy = estimate.healthy,
          .prediction_valid = estimate.prediction_valid,
          .in_control = controller.link().authority().in_control,
          .failsafe_state = controller.supervisor().failsafe_state(),
          .task_flies = seen.orders.task_flies,
          .has_battery = (telemetry.items & static_cast<std::uint16_t>(protocol::TelemetryItem::kBattery)) != 0,
          .battery_percent = telemetry.battery_percent};
}

mavlink::Heartbeat heartbeat_of(const FlightState& state) {
  const bool flies = state.failsafe_state != safety::FailsafeState::kSilent;
  return {.custom_mode = static_cast<std::uint32_t>(state.failsafe_state),
          .type = kQuadrotor,
          .autopilot = 0,
          .base_mode = static_cast<std::uint8_t>(kCustomModeFlag | (state.in_control ? kArmedFlag : 0) |
                                                 (flies ? kGuidedFlag : 0)),
          .system_status = system_status(state),
          .mavlink_version = kProtocolVersion};
}

mavlink::AttitudeQuaternion attitude_of(const FlightState& state) {
  const core::Quaternion<double> q = core::flip_yz(core::quaternion_of(core::attitude_of(state.tilt, state.yaw_rad)));
  return {.time_boot_ms = milliseconds(state.now),
          .q1 = static_cast<float>(q.w),
          .q2 = static_cast<float>(q.x),
          .q3 = static_cast<float>(q.y),
          .q4 = static_cast<float>(q.z),
          .rollspeed = state.rate_frd_rad_s[0],
          .pitchspeed = state.rate_frd_rad_s[1],
          .yawspeed = state.rate_frd_rad_s[2],
          .repr_offset_q = {}};
}

mavlink::LocalPositionNed position_of(const FlightState& state) {
  return {.time_boot_ms = milliseconds(state.now),
          .x = ned(state.position_w_m, 0),
          .y = ned(state.position_w_m, 1),
          .z = ned(state.position_w_m, 2),
          .vx = ned(state.velocity_w_m_s, 0),
          .vy = ned(state.velocity_w_m_s, 1),
          .vz = ned(state.velocity_w_m_s, 2)};
}

mavlink::EstimatorStatus estimator_of(const FlightState& state) {
  return {.time_usec = static_cast<std::uint64_t>(state.now.time_since_epoch().count()),
          .pos_horiz_ratio = static_cast<float>(state.gate_ratio),
          .pos_horiz_accuracy = static_cast<float>(state.horizontal_sigma_m),
          .flags = static_cast<std::uint16_t>((state.healthy ? kEstimateFlags : 0) |
                                              (state.prediction_valid || state.healthy ? kPredictedFlag : 0))};
}

mavlink::BatteryStatus battery_of(const FlightState& state) {
  mavlink::BatteryStatus message{.current_consumed = -1,
                                 .energy_consumed = -1,
                                 .temperature = std::numeric_limits<std::int16_t>::max(),
                                 .current_battery = -1,
                                 .battery_remaining = static_cast<std::int8_t>(
                                     state.has_battery ? std::min<std::uint8_t>(state.battery_percent, 100) : -1)};
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
