// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "protocol/frame_encoder.h"
#include "protocol/telemetry.h"

// Byte streams to try a receiver with: clean ones, and those a clever enemy of its processor time would send.
namespace m100::host_tests {

using Bytes = std::vector<std::byte>;

inline void append(Bytes& stream, std::span<const std::byte> more) {
  stream.insert(stream.end(), more.begin(), more.end());
}

Bytes make_frame(const protocol::Envelope& envelope, const protocol::MessageId* id, std::span<const std::byte> value,
                 const protocol::Cipher* cipher = nullptr);

/// A telemetry frame with all items (142 bytes), every value different for every number.
Bytes telemetry_frame(std::uint16_t number, std::uint16_t items = protocol::kAllTelemetryItems);

/// Twelve bytes whose CRC16 holds.
Bytes header(std::size_t length, std::uint8_t session, std::uint8_t cipher_byte, std::uint16_t sequence);

Bytes random_bytes(std::size_t count, std::mt19937& random);

/// Streams of about `count` bytes.
Bytes clean_telemetry(std::size_t count);
Bytes noise(std::size_t count);
Bytes start_bytes(std::size_t count);
/// Headers of 1023-byte frames, one after the other, and no such frame.
Bytes longest_headers(std::size_t count);
/// Good headers of false frames, as close as they can be: every eight bytes, since bytes 1 to 7 of a good header cannot
/// be the beginning of another. Each one's CRC16 is LEN and SESSION of the next, so they are searched for. The seed
/// decides which, and how they lie to the parser's blocks.
Bytes densest_headers(std::size_t count, unsigned seed = 1);
/// Clean frames, each preceded by a header that claims 1023 bytes.
Bytes frames_behind_false_headers(std::size_t count);

/// Good frames of random kinds and sizes among noise, cut frames, frames with flipped bits, false headers, headers as
/// close as they can be, runs of start bytes, frames inside frames and frames of another version of the protocol.
Bytes damaged_stream(std::size_t pieces, std::mt19937& random);

}  // namespace m100::host_tests
