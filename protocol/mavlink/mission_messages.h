// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <tuple>

#include "protocol/mavlink/layout.h"

namespace m100::mavlink {

// What MAVLink's mission protocol needs of a vehicle without missions: it refuses lists, and its own are empty.
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

/// MISSION_WRITE_PARTIAL_LIST: announces new items for a part of the list.
struct MissionWritePartialList {
  std::int16_t start_index{};
  std::int16_t end_index{};
  std::uint8_t target_system{};
  std::uint8_t target_component{};
  std::uint8_t mission_type{};
  static constexpr MessageInfo kInfo{.id = 38, .crc_extra = 9, .min_bytes = 6, .full_bytes = 7};
};

template <>
inline constexpr auto kFields<MissionWritePartialList> =
    std::tuple{field("start_index", &MissionWritePartialList::start_index),
               field("end_index", &MissionWritePartialList::end_index),
               field("target_system", &MissionWritePartialList::target_system),
               field("target_component", &MissionWritePartialList::target_component),
               field("mission_type", &MissionWritePartialList::mission_type)};

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

}  // namespace m100::mavlink
