// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/mavlink/frame.h"

#include <algorithm>

#include "protocol/bytes.h"
#include "protocol/crc_kernels.h"
#include "protocol/mavlink/messages.h"

namespace m100::mavlink {
namespace {

/// Messages of other systems that are not read here: because their checksums are known, their frames are skipped whole.
constexpr std::array kOnlyPassedOver{
    MessageInfo{.id = 1, .crc_extra = 124, .min_bytes = 31, .full_bytes = 43},    // SYS_STATUS
    MessageInfo{.id = 2, .crc_extra = 137, .min_bytes = 12, .full_bytes = 12},    // SYSTEM_TIME
    MessageInfo{.id = 4, .crc_extra = 237, .min_bytes = 14, .full_bytes = 14},    // PING
    MessageInfo{.id = 30, .crc_extra = 39, .min_bytes = 28, .full_bytes = 28},    // ATTITUDE
    MessageInfo{.id = 85, .crc_extra = 140, .min_bytes = 51, .full_bytes = 51},   // POSITION_TARGET_LOCAL_NED
    MessageInfo{.id = 148, .crc_extra = 178, .min_bytes = 60, .full_bytes = 78},  // AUTOPILOT_VERSION
    MessageInfo{.id = 241, .crc_extra = 90, .min_bytes = 32, .full_bytes = 32},   // VIBRATION
    MessageInfo{.id = 245, .crc_extra = 130, .min_bytes = 2, .full_bytes = 2},    // EXTENDED_SYS_STATE
    MessageInfo{.id = 256, .crc_extra = 71, .min_bytes = 42, .full_bytes = 42},   // SETUP_SIGNING
};

constexpr auto kKnown = [] {
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

/// The register after one byte, started from 0: CCITT's polynomial, reflected.
constexpr std::array<std::uint16_t, 256> kChecksumTable =
    protocol::crc_kernels::make_tables<std::uint16_t, 1>(0x8408)[0];

}  // namespace

std::uint16_t checksum(std::span<const std::byte> bytes, std::uint16_t state) {
  unsigned crc = state;
  const std::byte* next = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= 2; next += 2, left -= 2) {  // the second byte is added before the step of the first
    crc ^= protocol::load<std::uint16_t>(next);
    crc = (crc >> 8U) ^ kChecksumTable[crc & 0xFFU];
    crc = (crc >> 8U) ^ kChecksumTable[crc & 0xFFU];
  }
  if (left > 0) {
    crc = (crc >> 8U) ^ kChecksumTable[(std::to_integer<unsigned>(*next) ^ crc) & 0xFFU];
  }
  return static_cast<std::uint16_t>(crc);
}

const MessageInfo* find_message(std::uint32_t id) {
  const auto* const at = std::lower_bound(
      kKnown.begin(), kKnown.end(), id, [](const MessageInfo& info, std::uint32_t wanted) { return info.id < wanted; });
  return at != kKnown.end() && at->id == id ? at : nullptr;
}

Frame make_frame(const MessageInfo& info, std::span<const std::byte> payload, Address from, std::uint8_t sequence) {
  M100_ASSERT(payload.size() == info.full_bytes);
  while (payload.size() > 1 && payload.back() == std::byte{0}) {
    payload = payload.first(payload.size() - 1);
  }
  Frame frame;
  protocol::ByteWriter writer(frame.space);
  const auto put = [&writer](std::uint32_t value) { writer.put(static_cast<std::uint8_t>(value & 0xFFU)); };
  writer.put(std::span(&kStart2, 1));
  put(static_cast<std::uint32_t>(payload.size()));
  put(0);  // incompatibility flags
  put(0);  // compatibility flags
  put(sequence);
  put(from.system);
  put(from.component);
  put(info.id);
  put(info.id >> 8U);
  put(info.id >> 16U);
  writer.put(payload);
  const std::byte extra{info.crc_extra};
  writer.put(checksum(std::span(&extra, 1), checksum(writer.written().subspan(1))));
  frame.size = writer.size();
  return frame;
}

}  // namespace m100::mavlink
