// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/telemetry.h"

// Byte streams to test a receiver: clean ones, and hostile ones that cost it the most processor time.
namespace m100::host_tests {

using Bytes = std::vector<std::byte>;

inline void append(Bytes& stream, std::span<const std::byte> more) {
  stream.insert(stream.end(), more.begin(), more.end());
}

Bytes make_frame(const protocol::Envelope& envelope, const protocol::MessageId* id, std::span<const std::byte> value,
                 const protocol::Cipher* cipher = nullptr);

/// A telemetry frame with all items (142 bytes), with different values for each number.
Bytes telemetry_frame(std::uint16_t number, std::uint16_t items = protocol::kAllTelemetryItems);

/// A header of twelve bytes with a valid CRC16.
Bytes header(std::size_t length, std::uint8_t session, std::uint8_t cipher_byte, std::uint16_t sequence);

Bytes random_bytes(std::size_t count, std::mt19937& random);

/// Streams of about `count` bytes.
Bytes clean_telemetry(std::size_t count);
Bytes noise(std::size_t count);
Bytes start_bytes(std::size_t count);
/// Headers of 1023-byte frames, one after the other, without such a frame.
Bytes longest_headers(std::size_t count);
/// Valid headers of false frames as dense as possible: every eight bytes, because bytes 1 to 7 of a valid header cannot
/// begin another one. The CRC16 of each is LEN and SESSION of the next, so they have to be searched for. The seed
/// selects the headers and their alignment to the parser's blocks.
Bytes densest_headers(std::size_t count, unsigned seed = 1);
/// Clean frames, each preceded by a header that claims 1023 bytes.
Bytes frames_behind_false_headers(std::size_t count);

/// Good frames of random kinds and sizes among noise, cut frames, frames with flipped bits, false headers, headers as
/// dense as possible, runs of start bytes, frames inside frames and frames of another version of the protocol.
Bytes damaged_stream(std::size_t pieces, std::mt19937& random);

}  // namespace m100::host_tests
