// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <tuple>

#include "protocol/mavlink/layout.h"

namespace m100::mavlink {

// The mission protocol: a list of waypoints, transferred item by item.
// Members have the names of the message definitions, so that engineers who know those find them.
// Deviation: these names lack units; the comment of each structure gives them.

/// Messages about a whole list.
template <MessageInfo kMessage>
struct MissionListMessage {
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t mission_type{};
  static constexpr MessageInfo kInfo = kMessage;
};

template <MessageInfo kMessage>
inline constexpr auto kFields<MissionListMessage<kMessage>> = [] {
  using M = MissionListMessage<kMessage>;
  return std::tuple{field("target_system", &M::target_system), field("target_component", &M::target_component),
                    field("mission_type", &M::mission_type)};
}();

/// MISSION_REQUEST_LIST: requests the number of items.
using MissionRequestList = MissionListMessage<MessageInfo{.id = 43, .crc_extra = 132, .min_bytes = 2, .full_bytes = 3}>;
/// MISSION_CLEAR_ALL: forgets all items.
using MissionClearAll = MissionListMessage<MessageInfo{.id = 45, .crc_extra = 232, .min_bytes = 2, .full_bytes = 3}>;

/// Requests of one item.
template <MessageInfo kMessage>
struct MissionItemRequest {
  std::uint16_t seq{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t mission_type{};
  static constexpr MessageInfo kInfo = kMessage;
};

template <MessageInfo kMessage>
inline constexpr auto kFields<MissionItemRequest<kMessage>> = [] {
  using M = MissionItemRequest<kMessage>;
  return std::tuple{field("seq", &M::seq), field("target_system", &M::target_system),
                    field("target_component", &M::target_component), field("mission_type", &M::mission_type)};
}();

/// MISSION_REQUEST_INT.
using MissionRequestInt = MissionItemRequest<MessageInfo{.id = 51, .crc_extra = 196, .min_bytes = 4, .full_bytes = 5}>;
/// MISSION_REQUEST, of older senders; answered like MISSION_REQUEST_INT.
using MissionRequest = MissionItemRequest<MessageInfo{.id = 40, .crc_extra = 230, .min_bytes = 4, .full_bytes = 5}>;

/// One item. Coordinate is the type of x and y.
template <typename Coordinate, MessageInfo kMessage>
struct MissionItemMessage {
  float param1{};
  float param2{};
  float param3{};
  float param4{};
  Coordinate x{};
  Coordinate y{};
  float z{};
  std::uint16_t seq{};
  std::uint16_t command{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t frame{};
  std::uint8_t current{};
  std::uint8_t autocontinue{};
  std::uint8_t mission_type{};
  static constexpr MessageInfo kInfo = kMessage;
};

template <typename Coordinate, MessageInfo kMessage>
inline constexpr auto kFields<MissionItemMessage<Coordinate, kMessage>> = [] {
  using M = MissionItemMessage<Coordinate, kMessage>;
  return std::tuple{field("param1", &M::param1),
                    field("param2", &M::param2),
                    field("param3", &M::param3),
                    field("param4", &M::param4),
                    field("x", &M::x),
                    field("y", &M::y),
                    field("z", &M::z),
                    field("seq", &M::seq),
                    field("command", &M::command),
                    field("target_system", &M::target_system),
                    field("target_component", &M::target_component),
                    field("frame", &M::frame),
                    field("current", &M::current),
                    field("autocontinue", &M::autocontinue),
                    field("mission_type", &M::mission_type)};
}();

/// MISSION_ITEM, of older senders; x and y of a local frame in m.
using MissionItem =
    MissionItemMessage<float, MessageInfo{.id = 39, .crc_extra = 254, .min_bytes = 37, .full_bytes = 38}>;
/// MISSION_ITEM_INT; x and y of a local frame in 0.1 mm.
using MissionItemInt =
    MissionItemMessage<std::int32_t, MessageInfo{.id = 73, .crc_extra = 38, .min_bytes = 37, .full_bytes = 38}>;

/// MISSION_COUNT: announces a list of `count` items.
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
