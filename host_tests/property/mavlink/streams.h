// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

// Streams for the MAVLink parser's tests and for the search for its most expensive stream.
namespace m100::host_tests::mavlink_streams {

using Bytes = std::vector<std::byte>;

void append(Bytes& to, std::span<const std::byte> bytes);

/// ATT_POS_MOCAP frames with all fields in use, one after the other.
Bytes clean_poses(std::size_t count);

/// Start bytes of one version only.
Bytes start_bytes(std::size_t count, std::byte start);

/// As many headers of known messages as fit in: four in eleven bytes, each claims the longest payload or nearly so.
Bytes densest_headers(std::size_t count);

/// A repeated pattern of bytes that have a meaning in a header: start bytes, flags, ids and lengths of known messages.
Bytes pattern(std::mt19937& random, std::size_t count);

/// Headers of one known message with a length of any size, flags and address, separated by gaps of any size.
Bytes headers(std::mt19937& random, std::size_t count);

/// Good frames of any known message and length, some signed, some after or inside the claim of a false header.
Bytes frames_among_headers(std::mt19937& random, std::size_t count);

/// Where the frames of a stream begin, found by trying each start byte of the whole stream and summing each claimed
/// frame anew.
struct Reference {
  std::vector<std::uint64_t> offsets;
  std::uint64_t crc_errors = 0;
};
Reference reference_parse(std::span<const std::byte> stream);

}  // namespace m100::host_tests::mavlink_streams
