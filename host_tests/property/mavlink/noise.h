// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/mavlink/frame.h"

namespace m100::host_tests {

/// Makes frames out of noise. From back to front, turns the bytes after a start byte into the header of a known message
/// and repairs the checksum, if the frame fits. @param choice selects by its bits which start bytes are repaired, and
/// by its lower bits which message each becomes.
inline void repair_mavlink(std::span<std::byte> bytes, std::uint64_t choice) {
  constexpr std::array<std::uint8_t, 8> kIds{138, 102, 111, 84, 76, 0, 253, 44};
  for (std::size_t at = bytes.size(); at-- > 0;) {
    if (bytes[at] != mavlink::kStart2 || bytes.size() - at < mavlink::kHeader2Bytes + mavlink::kCrcBytes) {
      continue;
    }
    choice = (choice >> 1U) | (choice << 63U);
    if ((choice & 1U) == 0) {
      continue;
    }
    const std::span<std::byte> frame = bytes.subspan(at);
    const std::uint8_t id = kIds[(choice >> 5U) % kIds.size()];
    frame[2] &= std::byte{mavlink::kSignedFlag};
    frame[7] = std::byte{id};
    frame[8] = std::byte{0};
    frame[9] = std::byte{0};
    const std::size_t summed = mavlink::kHeader2Bytes + std::to_integer<std::size_t>(frame[1]);
    if (summed + mavlink::kCrcBytes > frame.size()) {
      continue;
    }
    const std::byte extra{mavlink::find_message(id)->crc_extra};
    const std::uint16_t sum = mavlink::checksum(std::span(&extra, 1), mavlink::checksum(frame.subspan(1, summed - 1)));
    frame[summed] = static_cast<std::byte>(sum & 0xFFU);
    frame[summed + 1] = static_cast<std::byte>(sum >> 8U);
  }
}

}  // namespace m100::host_tests
