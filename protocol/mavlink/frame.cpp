// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/mavlink/frame.h"

#include "protocol/bytes.h"
#include "protocol/mavlink/known_messages.h"
#include "protocol/mavlink/running_checksum.h"

namespace m100::mavlink {

std::uint16_t checksum(std::span<const std::byte> bytes, std::uint16_t state) {
  return static_cast<std::uint16_t>(protocol::continue_crc(kChecksumTable, state, bytes));
}

const MessageInfo* find_message(std::uint32_t id) { return known_messages::find(id); }

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
