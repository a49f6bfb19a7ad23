// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/expected.h"
#include "protocol/cipher.h"

namespace m100::protocol {

/// Sizes in bytes and numbers of the link frame; protocol/README.md has the layout.
inline constexpr std::byte kStartByte{0xAA};
inline constexpr std::size_t kHeaderBytes = 12;                       ///< the CRC16 included
inline constexpr std::size_t kFrameOverheadBytes = kHeaderBytes + 4;  ///< of a frame that has DATA
inline constexpr std::size_t kMaxFrameBytes = 1023;                   ///< LEN has 10 bits
/// More than the longest frame that an autopilot sends to us: an N1's telemetry with every item, encrypted, 144 bytes.
inline constexpr std::size_t kMaxAutopilotFrameBytes = 160;
inline constexpr std::size_t kMaxDataBytes = kMaxFrameBytes - kFrameOverheadBytes;
inline constexpr std::size_t kMaxEncryptedDataBytes = 992;  ///< 62 cipher blocks
inline constexpr std::size_t kMessageIdBytes = 2;
inline constexpr std::uint8_t kSessionCount = 32;

/// The type of a command or push: the first two bytes of its DATA. An acknowledgement carries none.
struct MessageId {
  std::uint8_t set = 0;
  std::uint8_t id = 0;
  friend constexpr auto operator<=>(const MessageId&, const MessageId&) = default;
};

/// The fields of a header that are not fixed.
struct FrameHeader {
  std::uint16_t length_bytes = 0;  ///< of the whole frame on the wire, 12 or 16..1023
  std::uint8_t session = 0;        ///< 0..31
  bool is_ack = false;
  std::uint8_t encryption = 0;     ///< 0 plain, anything else AES-256 (a sender writes 1)
  std::uint8_t padding_bytes = 0;  ///< filler at the end of decrypted DATA
  std::uint16_t sequence = 0;
  bool encrypted() const { return encryption != 0; }
};

/// A frame as received, both checksums good (without DATA there is only the CRC16). Views the buffer of the parser.
struct FrameView {
  FrameHeader header;
  std::span<const std::byte> bytes;  ///< the whole frame
  std::span<const std::byte> data;   ///< DATA, still encrypted if the header says so
  std::uint64_t offset = 0;          ///< stream position of its start byte
};

/// A frame after decryption: its header, id and value. Views the frame or the scratch space given to open().
struct Message {
  FrameHeader header;
  bool has_id = false;  ///< false for acknowledgements and for DATA shorter than an id
  MessageId id;
  std::span<const std::byte> value;   ///< without id and filler
  std::span<const std::byte> filler;  ///< decrypted filler, meaningless
};

using CipherScratch = std::array<std::byte, kMaxEncryptedDataBytes>;

/// Decrypts (if needed) and splits a frame. The plain text is not checked: a wrong key gives a wrong message.
/// @param cipher may be null while there is no key.
/// @returns kUnavailable: encrypted, no cipher. kInvalidArgument: DATA is not whole blocks or shorter than its filler.
core::Expected<Message> open(const FrameView& frame, const Cipher* cipher, CipherScratch& scratch);

}  // namespace m100::protocol
