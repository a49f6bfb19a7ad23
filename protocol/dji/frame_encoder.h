// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/expected.h"
#include "protocol/cipher.h"
#include "protocol/dji/frame.h"

namespace m100::protocol {

/// The header fields that a sender chooses.
struct Envelope {
  std::uint8_t session = 0;
  bool is_ack = false;
  bool encrypted = false;
  std::uint16_t sequence = 0;
};

/// Bytes on the wire of a frame with `data_bytes` of plain DATA (an id counts as two).
constexpr std::size_t frame_bytes(std::size_t data_bytes, bool encrypted) {
  if (data_bytes == 0) {
    return kHeaderBytes;
  }
  return kFrameOverheadBytes + (encrypted ? (data_bytes / kCipherBlockBytes + 1) * kCipherBlockBytes : data_bytes);
}

/// Writes one frame into space: header, DATA (id first if there is one), filler, cipher, CRC16, CRC32.
///
/// @param id null for an acknowledgement, which carries none.
/// @param cipher may be null if the envelope is not encrypted.
/// @param filler content of the encryption filler; zeros where it is too short. No receiver may read it; a test passes
///   it to reproduce the bytes of a recorded frame.
/// @returns the written part of space.
///   kInvalidArgument: session above 31, an acknowledgement with an id, or an encrypted frame without DATA.
///   kOutOfRange: too long for LEN. kResourceExhausted: space is too small. kUnavailable: no cipher.
core::Expected<std::span<const std::byte>> encode_frame(const Envelope& envelope, const MessageId* id,
                                                        std::span<const std::byte> value, std::span<std::byte> space,
                                                        const Cipher* cipher = nullptr,
                                                        std::span<const std::byte> filler = {});

}  // namespace m100::protocol
