// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/expected.h"

namespace m100::protocol {

// Our own message, on a UART of its own: the pose from motion capture or any other source of pose. Fixed size, so a
// board reads it without a heap and a sender writes it with one struct.pack.
//
//   offset size                                        offset size
//        0   2  magic, 'P' 'M'                             12  12  f32 x 3: position, world NWU [m]
//        2   1  version, 1                                 24  16  f32 x 4: body FLU in world NWU, w x y z
//        3   1  zero                                       40   4  u32: CRC32 of bytes 0..39
//        4   4  u32: sequence, +1 per message
//        8   4  u32: age when sent [us]: capture to send
//
// Little-endian; the CRC32 is that of the link frame (README). At 100 Hz it takes 38 % of 115200 baud.

inline constexpr std::size_t kPoseMessageBytes = 44;

struct PoseMessage {
  std::uint32_t sequence = 0;
  std::uint32_t age_us = 0;                              ///< from capture to send
  std::array<float, 3> position_w_m{};                   ///< world NWU
  std::array<float, 4> rotation_wb{1.F, 0.F, 0.F, 0.F};  ///< unit quaternion w x y z: turns FLU vectors into NWU
};

using PoseBytes = std::array<std::byte, kPoseMessageBytes>;

PoseBytes encode(const PoseMessage& message);

/// kOk if every number is finite, the position within 1 km, the quaternion's length within 1 % of one, and the age
/// below ten seconds; else kOutOfRange.
core::Status check(const PoseMessage& message);

/// Finds pose messages in a byte stream that may start anywhere and may be damaged anywhere.
///
/// Cost: O(1) per byte, plus one CRC over 40 bytes for each place that looks like a beginning and is 44 bytes long.
class PoseParser {
 public:
  struct Stats {
    std::uint64_t bytes = 0;
    std::uint64_t messages = 0;
    std::uint64_t crc_errors = 0;
    std::uint64_t bytes_dropped = 0;
    std::uint64_t refused = 0;  ///< good checksum, numbers that check() refuses
  };

  /// Feeds one byte.
  /// @returns the message it completes. kNotReady: none is complete yet. kOutOfRange: one is, but check() refuses it.
  core::Expected<PoseMessage> push(std::byte value) {
    std::span<const std::byte> one(&value, 1);
    return take(one) ? judge() : core::Expected<PoseMessage>(core::Status::kNotReady);
  }
  /// The same in two steps, for many bytes: takes some off the front, at least one. @returns true when they make a
  /// message whole; then judge() it, before the next. judge() says kNotReady for a wrong checksum.
  bool take(std::span<const std::byte>& bytes);
  core::Expected<PoseMessage> judge();

  const Stats& stats() const { return stats_; }

 private:
  bool may_begin() const;
  void drop_first();
  void find_beginning();

  std::array<std::byte, kPoseMessageBytes> window_{};
  std::size_t size_ = 0;
  Stats stats_;
};

}  // namespace m100::protocol
