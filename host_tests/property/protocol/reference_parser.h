// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "host_tests/property/protocol/streams.h"

namespace m100::host_tests {

struct FoundFrame {
  std::uint64_t offset = 0;
  Bytes bytes;
  bool operator==(const FoundFrame&) const = default;
};

/// Finds the frames of a whole stream directly by the rules, without a buffer, a running checksum or optimisation:
/// start byte, both checksums bit by bit, all fixed fields zero, a possible length, filler inside whole cipher blocks.
/// After a frame the search continues eleven bytes before its end, as in DJI's receiver.
/// A valid header whose frame is cut off by the end of the stream ends the search: a receiver still waits for the rest.
std::vector<FoundFrame> slow_parse(const Bytes& stream);

}  // namespace m100::host_tests
