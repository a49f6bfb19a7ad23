// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <tuple>

#include "protocol/mavlink/layout.h"

namespace m100::mavlink {

// The mission protocol: a list of waypoints, transferred item by item.
// Members have the names of the message definitions, so that engineers who know those find them.
// Deviation: so they lack units; the comment of each structure gives them.

/// MISSION_REQUEST_LIST: requests the number of items.
struct MissionRequestList {
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t mission_type{};
  static constexpr MessageInfo kInfo{.id = 43, .crc_extra = 132, .min_bytes = 2, .full_bytes = 3};
};

template <>
inline constexpr auto kFields<MissionRequestList> =
    std::tuple{field("target_system", &MissionRequestList::target_system),
               field("target_component", &MissionRequestList::target_component),
               field("mission_type", &MissionRequestList::mission_type)};

/// MISSION_COUNT: announces that many items.
struct MissionCount {
  std::uint16_t count{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t mission_type{};
  std::uint32_t opaque_id{};
  static constexpr MessageInfo kInfo{.id = 44, .crc_extra = 221, .min_bytes = 4, .full_bytes = 9};
};

template <>
inline constexpr auto kFields<MissionCount> =
    std::tuple{field("count", &MissionCount::count), field("target_system", &MissionCount::target_system),
               field("target_component", &MissionCount::target_component),
               field("mission_type", &MissionCount::mission_type), field("opaque_id", &MissionCount::opaque_id)};

/// MISSION_REQUEST_INT: requests one item.
struct MissionRequestInt {
  std::uint16_t seq{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t mission_type{};
  static constexpr MessageInfo kInfo{.id = 51, .crc_extra = 196, .min_bytes = 4, .full_bytes = 5};
};

template <>
inline constexpr auto kFields<MissionRequestInt> =
    std::tuple{field("seq", &MissionRequestInt::seq), field("target_system", &MissionRequestInt::target_system),
               field("target_component", &MissionRequestInt::target_component),
               field("mission_type", &MissionRequestInt::mission_type)};

/// MISSION_REQUEST: requests one item, as older senders do; answered like MISSION_REQUEST_INT.
struct MissionRequest {
  std::uint16_t seq{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t mission_type{};
  static constexpr MessageInfo kInfo{.id = 40, .crc_extra = 230, .min_bytes = 4, .full_bytes = 5};
};

template <>
inline constexpr auto kFields<MissionRequest> = std::tuple{
    field("seq", &MissionRequest::seq), field("target_system", &MissionRequest::target_system),
    field("target_component", &MissionRequest::target_component), field("mission_type", &MissionRequest::mission_type)};

/// MISSION_ITEM: one item, as older senders send it; x and y of a local frame in m.
struct MissionItem {
  float param1{};
  float param2{};
  float param3{};
  float param4{};
  float x{};
  float y{};
  float z{};
  std::uint16_t seq{};
  std::uint16_t command{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t frame{};
  std::uint8_t current{};
  std::uint8_t autocontinue{};
  std::uint8_t mission_type{};
  static constexpr MessageInfo kInfo{.id = 39, .crc_extra = 254, .min_bytes = 37, .full_bytes = 38};
};

template <>
inline constexpr auto kFields<MissionItem> = std::tuple{field("param1", &MissionItem::param1),
                                                        field("param2", &MissionItem::param2),
                                                        field("param3", &MissionItem::param3),
                                                        field("param4", &MissionItem::param4),
                                                        field("x", &MissionItem::x),
                                                        field("y", &MissionItem::y),
                                                        field("z", &MissionItem::z),
                                                        field("seq", &MissionItem::seq),
                                                        field("command", &MissionItem::command),
                                                        field("target_system", &MissionItem::target_system),
                                                        field("target_component", &MissionItem::target_component),
                                                        field("frame", &MissionItem::frame),
                                                        field("current", &MissionItem::current),
                                                        field("autocontinue", &MissionItem::autocontinue),
                                                        field("mission_type", &MissionItem::mission_type)};

/// MISSION_ITEM_INT: one item; x and y of a local frame in 0.1 mm.
struct MissionItemInt {
  float param1{};
  float param2{};
  float param3{};
  float param4{};
  std::int32_t x{};
  std::int32_t y{};
  float z{};
  std::uint16_t seq{};
  std::uint16_t command{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t frame{};
  std::uint8_t current{};
  std::uint8_t autocontinue{};
  std::uint8_t mission_type{};
  static constexpr MessageInfo kInfo{.id = 73, .crc_extra = 38, .min_bytes = 37, .full_bytes = 38};
};

template <>
inline constexpr auto kFields<MissionItemInt> = std::tuple{field("param1", &MissionItemInt::param1),
                                                           field("param2", &MissionItemInt::param2),
                                                           field("param3", &MissionItemInt::param3),
                                                           field("param4", &MissionItemInt::param4),
                                                           field("x", &MissionItemInt::x),
                                                           field("y", &MissionItemInt::y),
                                                           field("z", &MissionItemInt::z),
                                                           field("seq", &MissionItemInt::seq),
                                                           field("command", &MissionItemInt::command),
                                                           field("target_system", &MissionItemInt::target_system),
                                                           field("target_component", &MissionItemInt::target_component),
                                                           field("frame", &MissionItemInt::frame),
                                                           field("current", &MissionItemInt::current),
                                                           field("autocontinue", &MissionItemInt::autocontinue),
                                                           field("mission_type", &MissionItemInt::mission_type)};

/// MISSION_ACK: ends a transfer, with its result.
struct MissionAck {
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t type{};
  std::uint8_t mission_type{};
  std::uint32_t opaque_id{};
  static constexpr MessageInfo kInfo{.id = 47, .crc_extra = 153, .min_bytes = 3, .full_bytes = 8};
};

template <>
inline constexpr auto kFields<MissionAck> =
    std::tuple{field("target_system", &MissionAck::target_system),
               field("target_component", &MissionAck::target_component), field("type", &MissionAck::type),
               field("mission_type", &MissionAck::mission_type), field("opaque_id", &MissionAck::opaque_id)};

/// MISSION_CLEAR_ALL: forgets all items.
struct MissionClearAll {
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t mission_type{};
  static constexpr MessageInfo kInfo{.id = 45, .crc_extra = 232, .min_bytes = 2, .full_bytes = 3};
};

template <>
inline constexpr auto kFields<MissionClearAll> =
    std::tuple{field("target_system", &MissionClearAll::target_system),
               field("target_component", &MissionClearAll::target_component),
               field("mission_type", &MissionClearAll::mission_type)};

/// MISSION_CURRENT: the item that is being flown.
struct MissionCurrent {
  std::uint16_t seq{};
  std::uint16_t total{};
  std::uint8_t mission_state{};
  std::uint8_t mission_mode{};
  std::uint32_t mission_id{};
  std::uint32_t fence_id{};
  std::uint32_t rally_points_id{};
  static constexpr MessageInfo kInfo{.id = 42, .crc_extra = 28, .min_bytes = 2, .full_bytes = 18};
};

template <>
inline constexpr auto kFields<MissionCurrent> = std::tuple{field("seq", &MissionCurrent::seq),
                                                           field("total", &MissionCurrent::total),
                                                           field("mission_state", &MissionCurrent::mission_state),
                                                           field("mission_mode", &MissionCurrent::mission_mode),
                                                           field("mission_id", &MissionCurrent::mission_id),
                                                           field("fence_id", &MissionCurrent::fence_id),
                                                           field("rally_points_id", &MissionCurrent::rally_points_id)};

/// MISSION_ITEM_REACHED.
struct MissionItemReached {
  std::uint16_t seq{};
  static constexpr MessageInfo kInfo{.id = 46, .crc_extra = 11, .min_bytes = 2, .full_bytes = 2};
};

template <>
inline constexpr auto kFields<MissionItemReached> = std::tuple{field("seq", &MissionItemReached::seq)};

}  // namespace m100::mavlink
