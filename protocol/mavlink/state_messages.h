// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <tuple>

#include "protocol/mavlink/layout.h"

namespace m100::mavlink {

// Messages about the state of the aircraft.
// Members have the names of the message definitions, so that engineers who know those find them.
// Deviation: these names lack units; the comment of each structure gives them.

/// HEARTBEAT: every component sends one per second.
struct Heartbeat {
  std::uint32_t custom_mode{};
  std::uint8_t type{};
  std::uint8_t autopilot{};
  std::uint8_t base_mode{};
  std::uint8_t system_status{};
  std::uint8_t mavlink_version{};
  static constexpr MessageInfo kInfo{.id = 0, .crc_extra = 50, .min_bytes = 9, .full_bytes = 9};
};

template <>
inline constexpr auto kFields<Heartbeat> = std::tuple{
    field("custom_mode", &Heartbeat::custom_mode),     field("type", &Heartbeat::type),
    field("autopilot", &Heartbeat::autopilot),         field("base_mode", &Heartbeat::base_mode),
    field("system_status", &Heartbeat::system_status), field("mavlink_version", &Heartbeat::mavlink_version)};

/// ATTITUDE_QUATERNION: body FRD in NED, w x y z; rates in rad/s.
struct AttitudeQuaternion {
  std::uint32_t time_boot_ms{};
  float q1{};
  float q2{};
  float q3{};
  float q4{};
  float rollspeed{};
  float pitchspeed{};
  float yawspeed{};
  std::array<float, 4> repr_offset_q{};
  static constexpr MessageInfo kInfo{.id = 31, .crc_extra = 246, .min_bytes = 32, .full_bytes = 48};
};

template <>
inline constexpr auto kFields<AttitudeQuaternion> =
    std::tuple{field("time_boot_ms", &AttitudeQuaternion::time_boot_ms),
               field("q1", &AttitudeQuaternion::q1),
               field("q2", &AttitudeQuaternion::q2),
               field("q3", &AttitudeQuaternion::q3),
               field("q4", &AttitudeQuaternion::q4),
               field("rollspeed", &AttitudeQuaternion::rollspeed),
               field("pitchspeed", &AttitudeQuaternion::pitchspeed),
               field("yawspeed", &AttitudeQuaternion::yawspeed),
               field("repr_offset_q", &AttitudeQuaternion::repr_offset_q)};

/// LOCAL_POSITION_NED: m and m/s.
struct LocalPositionNed {
  std::uint32_t time_boot_ms{};
  float x{};
  float y{};
  float z{};
  float vx{};
  float vy{};
  float vz{};
  static constexpr MessageInfo kInfo{.id = 32, .crc_extra = 185, .min_bytes = 28, .full_bytes = 28};
};

template <>
inline constexpr auto kFields<LocalPositionNed> = std::tuple{field("time_boot_ms", &LocalPositionNed::time_boot_ms),
                                                             field("x", &LocalPositionNed::x),
                                                             field("y", &LocalPositionNed::y),
                                                             field("z", &LocalPositionNed::z),
                                                             field("vx", &LocalPositionNed::vx),
                                                             field("vy", &LocalPositionNed::vy),
                                                             field("vz", &LocalPositionNed::vz)};

/// ESTIMATOR_STATUS: innovations over their gates, accuracies in m, and the valid estimates.
struct EstimatorStatus {
  std::uint64_t time_usec{};
  float vel_ratio{};
  float pos_horiz_ratio{};
  float pos_vert_ratio{};
  float mag_ratio{};
  float hagl_ratio{};
  float tas_ratio{};
  float pos_horiz_accuracy{};
  float pos_vert_accuracy{};
  std::uint16_t flags{};
  static constexpr MessageInfo kInfo{.id = 230, .crc_extra = 163, .min_bytes = 42, .full_bytes = 42};
};

template <>
inline constexpr auto kFields<EstimatorStatus> =
    std::tuple{field("time_usec", &EstimatorStatus::time_usec),
               field("vel_ratio", &EstimatorStatus::vel_ratio),
               field("pos_horiz_ratio", &EstimatorStatus::pos_horiz_ratio),
               field("pos_vert_ratio", &EstimatorStatus::pos_vert_ratio),
               field("mag_ratio", &EstimatorStatus::mag_ratio),
               field("hagl_ratio", &EstimatorStatus::hagl_ratio),
               field("tas_ratio", &EstimatorStatus::tas_ratio),
               field("pos_horiz_accuracy", &EstimatorStatus::pos_horiz_accuracy),
               field("pos_vert_accuracy", &EstimatorStatus::pos_vert_accuracy),
               field("flags", &EstimatorStatus::flags)};

/// BATTERY_STATUS: voltages in mV (65535: no such cell), current_battery in 10 mA, temperature in 0.01 degrees Celsius,
/// current_consumed in mAh, energy_consumed in 100 J, battery_remaining in percent, time_remaining in s.
struct BatteryStatus {
  std::int32_t current_consumed{};
  std::int32_t energy_consumed{};
  std::int16_t temperature{};
  std::array<std::uint16_t, 10> voltages{};
  std::int16_t current_battery{};
  std::uint8_t id{};
  std::uint8_t battery_function{};
  std::uint8_t type{};
  std::int8_t battery_remaining{};
  std::int32_t time_remaining{};
  std::uint8_t charge_state{};
  std::array<std::uint16_t, 4> voltages_ext{};
  std::uint8_t mode{};
  std::uint32_t fault_bitmask{};
  static constexpr MessageInfo kInfo{.id = 147, .crc_extra = 154, .min_bytes = 36, .full_bytes = 54};
};

template <>
inline constexpr auto kFields<BatteryStatus> = std::tuple{field("current_consumed", &BatteryStatus::current_consumed),
                                                          field("energy_consumed", &BatteryStatus::energy_consumed),
                                                          field("temperature", &BatteryStatus::temperature),
                                                          field("voltages", &BatteryStatus::voltages),
                                                          field("current_battery", &BatteryStatus::current_battery),
                                                          field("id", &BatteryStatus::id),
                                                          field("battery_function", &BatteryStatus::battery_function),
                                                          field("type", &BatteryStatus::type),
                                                          field("battery_remaining", &BatteryStatus::battery_remaining),
                                                          field("time_remaining", &BatteryStatus::time_remaining),
                                                          field("charge_state", &BatteryStatus::charge_state),
                                                          field("voltages_ext", &BatteryStatus::voltages_ext),
                                                          field("mode", &BatteryStatus::mode),
                                                          field("fault_bitmask", &BatteryStatus::fault_bitmask)};

/// STATUSTEXT: a text message, in pieces of 50 characters.
struct StatusText {
  std::uint8_t severity{};
  std::array<char, 50> text{};
  std::uint16_t id{};
  std::uint8_t chunk_seq{};
  static constexpr MessageInfo kInfo{.id = 253, .crc_extra = 83, .min_bytes = 51, .full_bytes = 54};
};

template <>
inline constexpr auto kFields<StatusText> =
    std::tuple{field("severity", &StatusText::severity), field("text", &StatusText::text), field("id", &StatusText::id),
               field("chunk_seq", &StatusText::chunk_seq)};

}  // namespace m100::mavlink
