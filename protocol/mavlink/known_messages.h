// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "protocol/mavlink/messages.h"

// The constants of every message whose checksum is known. Only frame.cpp and parser.cpp include it.
namespace m100::mavlink::known_messages {

/// Messages of other systems that nothing here decodes. Their checksums are known, so the parser finds their frames.
inline constexpr std::array kOnlyPassedOver{
    MessageInfo{.id = 1, .crc_extra = 124, .min_bytes = 31, .full_bytes = 43},    // SYS_STATUS
    MessageInfo{.id = 2, .crc_extra = 137, .min_bytes = 12, .full_bytes = 12},    // SYSTEM_TIME
    MessageInfo{.id = 4, .crc_extra = 237, .min_bytes = 14, .full_bytes = 14},    // PING
    MessageInfo{.id = 23, .crc_extra = 168, .min_bytes = 23, .full_bytes = 23},   // PARAM_SET
    MessageInfo{.id = 30, .crc_extra = 39, .min_bytes = 28, .full_bytes = 28},    // ATTITUDE
    MessageInfo{.id = 42, .crc_extra = 28, .min_bytes = 2, .full_bytes = 18},     // MISSION_CURRENT
    MessageInfo{.id = 46, .crc_extra = 11, .min_bytes = 2, .full_bytes = 2},      // MISSION_ITEM_REACHED
    MessageInfo{.id = 51, .crc_extra = 196, .min_bytes = 4, .full_bytes = 5},     // MISSION_REQUEST_INT
    MessageInfo{.id = 73, .crc_extra = 38, .min_bytes = 37, .full_bytes = 38},    // MISSION_ITEM_INT
    MessageInfo{.id = 85, .crc_extra = 140, .min_bytes = 51, .full_bytes = 51},   // POSITION_TARGET_LOCAL_NED
    MessageInfo{.id = 148, .crc_extra = 178, .min_bytes = 60, .full_bytes = 78},  // AUTOPILOT_VERSION
    MessageInfo{.id = 241, .crc_extra = 90, .min_bytes = 32, .full_bytes = 32},   // VIBRATION
    MessageInfo{.id = 245, .crc_extra = 130, .min_bytes = 2, .full_bytes = 2},    // EXTENDED_SYS_STATE
    MessageInfo{.id = 256, .crc_extra = 71, .min_bytes = 42, .full_bytes = 42},   // SETUP_SIGNING
};

inline constexpr auto kKnown = [] {
  std::array<MessageInfo, std::tuple_size_v<Messages> + kOnlyPassedOver.size()> all{};
  std::size_t count = 0;
  for_each_message([&]<typename Message>() { all[count++] = Message::kInfo; });
  for (const MessageInfo& info : kOnlyPassedOver) {
    all[count++] = info;
  }
  std::sort(all.begin(), all.end(), [](const MessageInfo& a, const MessageInfo& b) { return a.id < b.id; });
  return all;
}();
static_assert(std::adjacent_find(kKnown.begin(), kKnown.end(),
                                 [](const MessageInfo& a, const MessageInfo& b) { return a.id == b.id; }) ==
                  kKnown.end(),
              "a message has one row");

inline constexpr std::size_t kSlotBits = 7;
constexpr std::size_t slot_of(std::uint32_t id, std::uint32_t factor) { return (id * factor) >> (32U - kSlotBits); }

/// The row of each id without a search, by a factor that gives every known id a slot of its own.
struct Slots {
  std::uint32_t factor = 0;
  std::array<std::uint8_t, std::size_t{1} << kSlotBits> rows{};
};
inline constexpr Slots kSlots = [] {
  for (std::uint32_t factor = 1;; factor = 1664525U * factor + 1013904223U) {  // pseudo-random
    Slots slots{.factor = factor};
    std::array<bool, slots.rows.size()> taken{};
    std::size_t row = 0;
    while (row < kKnown.size() && !taken[slot_of(kKnown[row].id, factor)]) {
      taken[slot_of(kKnown[row].id, factor)] = true;
      slots.rows[slot_of(kKnown[row].id, factor)] = static_cast<std::uint8_t>(row);
      ++row;
    }
    if (row == kKnown.size()) {
      return slots;
    }
  }
}();

/// As find_message().
inline const MessageInfo* find(std::uint32_t id) {
  const MessageInfo& row = kKnown[kSlots.rows[slot_of(id, kSlots.factor)]];
  return row.id == id ? &row : nullptr;
}

}  // namespace m100::mavlink::known_messages
