// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <tuple>

#include "protocol/mavlink/layout.h"

namespace m100::mavlink {

// Messages of an operator or a planner, and the answers to them.
// Members have the names of the message definitions, so that engineers who know those find them.
// Deviation: these names lack units; the comment of each structure gives them.

/// SET_POSITION_TARGET_LOCAL_NED: a goal, in m, m/s, m/s^2, rad, rad/s; a set bit of type_mask: the field is ignored.
struct SetPositionTargetLocalNed {
  std::uint32_t time_boot_ms{};
  float x{};
  float y{};
  float z{};
  float vx{};
  float vy{};
  float vz{};
  float afx{};
  float afy{};
  float afz{};
  float yaw{};
  float yaw_rate{};
  std::uint16_t type_mask{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t coordinate_frame{};
  static constexpr MessageInfo kInfo{.id = 84, .crc_extra = 143, .min_bytes = 53, .full_bytes = 53};
};

template <>
inline constexpr auto kFields<SetPositionTargetLocalNed> =
    std::tuple{field("time_boot_ms", &SetPositionTargetLocalNed::time_boot_ms),
               field("x", &SetPositionTargetLocalNed::x),
               field("y", &SetPositionTargetLocalNed::y),
               field("z", &SetPositionTargetLocalNed::z),
               field("vx", &SetPositionTargetLocalNed::vx),
               field("vy", &SetPositionTargetLocalNed::vy),
               field("vz", &SetPositionTargetLocalNed::vz),
               field("afx", &SetPositionTargetLocalNed::afx),
               field("afy", &SetPositionTargetLocalNed::afy),
               field("afz", &SetPositionTargetLocalNed::afz),
               field("yaw", &SetPositionTargetLocalNed::yaw),
               field("yaw_rate", &SetPositionTargetLocalNed::yaw_rate),
               field("type_mask", &SetPositionTargetLocalNed::type_mask),
               field("target_system", &SetPositionTargetLocalNed::target_system),
               field("target_component", &SetPositionTargetLocalNed::target_component),
               field("coordinate_frame", &SetPositionTargetLocalNed::coordinate_frame)};

/// COMMAND_LONG: an order with seven numbers.
struct CommandLong {
  float param1{};
  float param2{};
  float param3{};
  float param4{};
  float param5{};
  float param6{};
  float param7{};
  std::uint16_t command{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t confirmation{};
  static constexpr MessageInfo kInfo{.id = 76, .crc_extra = 152, .min_bytes = 33, .full_bytes = 33};
};

template <>
inline constexpr auto kFields<CommandLong> = std::tuple{field("param1", &CommandLong::param1),
                                                        field("param2", &CommandLong::param2),
                                                        field("param3", &CommandLong::param3),
                                                        field("param4", &CommandLong::param4),
                                                        field("param5", &CommandLong::param5),
                                                        field("param6", &CommandLong::param6),
                                                        field("param7", &CommandLong::param7),
                                                        field("command", &CommandLong::command),
                                                        field("target_system", &CommandLong::target_system),
                                                        field("target_component", &CommandLong::target_component),
                                                        field("confirmation", &CommandLong::confirmation)};

/// COMMAND_ACK: the result of an order.
struct CommandAck {
  std::uint16_t command{};
  std::uint8_t result{};
  std::uint8_t progress{};
  std::int32_t result_param2{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  static constexpr MessageInfo kInfo{.id = 77, .crc_extra = 143, .min_bytes = 3, .full_bytes = 10};
};

template <>
inline constexpr auto kFields<CommandAck> = std::tuple{field("command", &CommandAck::command),
                                                       field("result", &CommandAck::result),
                                                       field("progress", &CommandAck::progress),
                                                       field("result_param2", &CommandAck::result_param2),
                                                       field("target_system", &CommandAck::target_system),
                                                       field("target_component", &CommandAck::target_component)};

/// PARAM_REQUEST_READ: requests one parameter, by index, or by name if the index is -1.
struct ParamRequestRead {
  std::int16_t param_index{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::array<char, 16> param_id{};
  static constexpr MessageInfo kInfo{.id = 20, .crc_extra = 214, .min_bytes = 20, .full_bytes = 20};
};

template <>
inline constexpr auto kFields<ParamRequestRead> = std::tuple{
    field("param_index", &ParamRequestRead::param_index), field("target_system", &ParamRequestRead::target_system),
    field("target_component", &ParamRequestRead::target_component), field("param_id", &ParamRequestRead::param_id)};

/// PARAM_REQUEST_LIST: requests all parameters.
struct ParamRequestList {
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  static constexpr MessageInfo kInfo{.id = 21, .crc_extra = 159, .min_bytes = 2, .full_bytes = 2};
};

template <>
inline constexpr auto kFields<ParamRequestList> =
    std::tuple{field("target_system", &ParamRequestList::target_system),
               field("target_component", &ParamRequestList::target_component)};

/// PARAM_VALUE: one parameter.
struct ParamValue {
  float param_value{};
  std::uint16_t param_count{};
  std::uint16_t param_index{};
  std::array<char, 16> param_id{};
  std::uint8_t param_type{};
  static constexpr MessageInfo kInfo{.id = 22, .crc_extra = 220, .min_bytes = 25, .full_bytes = 25};
};

template <>
inline constexpr auto kFields<ParamValue> =
    std::tuple{field("param_value", &ParamValue::param_value), field("param_count", &ParamValue::param_count),
               field("param_index", &ParamValue::param_index), field("param_id", &ParamValue::param_id),
               field("param_type", &ParamValue::param_type)};

}  // namespace m100::mavlink
