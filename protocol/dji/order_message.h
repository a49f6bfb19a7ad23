// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/expected.h"

namespace m100::protocol {

// Our own message, sent between pose messages on their UART: the position of the operator's switch, for a board that
// has neither a keyboard nor files. It carries a position, not an event, so that the next message replaces a lost one.
// The sender repeats it, for example ten times a second.
//
//   offset size
//        0   2  magic, 'P' 'O'
//        2   1  version, 1
//        3   1  0: the pilot flies; 1: the program shall fly
//        4   4  u32: CRC32 of bytes 0..3
//
// Little-endian; the CRC32 is that of the link frame (README). The parser of pose messages skips it.

inline constexpr std::size_t kOrderMessageBytes = 8;
using OrderBytes = std::array<std::byte, kOrderMessageBytes>;

OrderBytes encode_order(bool program_flies);

/// Finds orders in a byte stream that may start anywhere and may be damaged anywhere. Cost: O(1) per byte, plus one CRC
/// over four bytes for each place that looks like the beginning of a message.
class OrderParser {
 public:
  /// Feeds one byte.
  /// @returns the switch's position, if this byte completes a message. kNotReady: no message is complete. kDataLoss: a
  ///   message is complete, but its checksum is wrong.
  core::Expected<bool> push(std::byte value);

 private:
  OrderBytes last_{};  ///< oldest first
};

}  // namespace m100::protocol
