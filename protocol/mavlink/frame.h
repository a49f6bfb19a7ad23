// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/assert.h"
#include "protocol/mavlink/layout.h"

namespace m100::mavlink {

// MAVLink 2:  FD len incompat compat seq sys comp id(3) payload crc(2) [link id, time stamp(6), signature(6)]
// MAVLink 1:  FE len seq sys comp id payload crc(2)
// Little-endian. The checksum is CRC-16/MCRF4XX over everything between start byte and checksum, then the crc_extra of
// the message. MAVLink 2 leaves out trailing zeros of a payload, except for its first byte.

inline constexpr std::byte kStart2{0xFD};
inline constexpr std::byte kStart1{0xFE};
inline constexpr std::size_t kHeader2Bytes = 10;
inline constexpr std::size_t kHeader1Bytes = 6;
inline constexpr std::size_t kCrcBytes = 2;
inline constexpr std::size_t kSignatureBytes = 13;
inline constexpr std::size_t kMaxPayloadBytes = 255;
inline constexpr std::size_t kMaxFrameBytes = kHeader2Bytes + kMaxPayloadBytes + kCrcBytes + kSignatureBytes;
inline constexpr std::uint8_t kSignedFlag = 0x01;  ///< of the incompatibility flags, the only one that is defined

/// System and component of a sender or a target. 0 as a target means all.
struct Address {
  std::uint8_t system = 0;
  std::uint8_t component = 0;
  friend constexpr bool operator==(const Address&, const Address&) = default;
};

/// A frame whose checksum holds. The spans view the buffer that it was found in.
struct FrameView {
  std::uint32_t id = 0;
  Address from;
  std::uint8_t sequence = 0;
  std::uint8_t version = 2;  ///< of MAVLink
  bool is_signed = false;    ///< carries a signature that has not been verified yet (signature.h)
  std::span<const std::byte> bytes;
  std::span<const std::byte> payload;
  std::uint64_t offset = 0;  ///< of its first byte in the stream
};

/// A frame of our own.
struct Frame {
  std::array<std::byte, kMaxFrameBytes> space{};
  std::size_t size = 0;
  std::span<const std::byte> bytes() const { return std::span(space).first(size); }
};

/// CRC-16/MCRF4XX over the bytes, continued from state. Cost: one look-up a byte.
std::uint16_t checksum(std::span<const std::byte> bytes, std::uint16_t state = 0xFFFF);

/// The constants of a type of message. @returns null: unknown type, whose checksum cannot be verified.
const MessageInfo* find_message(std::uint32_t id);

/// Makes an unsigned frame of MAVLink 2. @param payload all fields, extensions included.
Frame make_frame(const MessageInfo& info, std::span<const std::byte> payload, Address from, std::uint8_t sequence);

template <typename Message>
Frame encode(const Message& message, Address from, std::uint8_t sequence) {
  std::array<std::byte, Message::kInfo.full_bytes> payload;
  return make_frame(Message::kInfo, encode_payload(message, payload), from, sequence);
}

template <typename Message>
bool is(const FrameView& frame) {
  return frame.id == Message::kInfo.id;
}

/// Fields that the sender left out are zero. @param frame must satisfy is<Message>().
template <typename Message>
Message decode(const FrameView& frame) {
  M100_ASSERT(is<Message>(frame));  // another message's bytes would become a pose or an order
  return decode_payload<Message>(frame.payload);
}

}  // namespace m100::mavlink
