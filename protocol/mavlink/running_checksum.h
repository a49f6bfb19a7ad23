// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "protocol/mavlink/checksum_kernels.h"

namespace m100::mavlink {

/// The MAVLink checksum of any range of a buffer, at a cost that does not depend on the length of the range.
///
/// Each byte of the buffer enters one running register at most once. The register is linear over GF(2), so the
/// difference of two runs over the same bytes changes with their number alone, whatever the bytes are
/// (see protocol/crc_kernels.h). The checksum of a range is therefore the running register at its end, plus the
/// difference at its begin carried over the length of the range.
class RunningChecksum {
 public:
  /// Bytes between two stored registers. A host has the memory to store one for each byte.
  static constexpr std::size_t kBlockBytes = checksum_kernels::kBlockBytes;
  static constexpr std::size_t kMaxBufferBytes = 512;
  static constexpr std::size_t kMaxRangeBytes = checksum_kernels::kMaxBlocks * kBlockBytes;
  /// A range of this length contains two stored registers, wherever it begins.
  static constexpr std::size_t kMinRangeBytes = 2 * kBlockBytes - 1;

  /// The checksum of buffer[begin] to buffer[end - 1], kMinRangeBytes to kMaxRangeBytes bytes. The begins of successive
  /// calls must not decrease.
  std::uint32_t of_range(const std::byte* buffer, std::size_t begin, std::size_t end) {
    const std::size_t first = (begin + kBlockBytes - 1) / kBlockBytes;
    const std::size_t last = end / kBlockBytes;
    const std::uint32_t own =
        checksum_kernels::step_rest(checksum_kernels::kStart, buffer + begin, buffer + first * kBlockBytes);
    if (known_ < first) {  // no earlier range needs the bytes in between: the run starts again behind them
      known_ = first;
      registers_[first] = static_cast<std::uint16_t>(own);
    }
    if (known_ < last) {
      run_to(buffer, last);
    }
    const std::uint32_t apart = registers_[first] ^ own;
    const std::uint32_t carried = apart != 0 ? checksum_kernels::advance(apart, last - first) : 0;
    return checksum_kernels::step_rest(registers_[last] ^ carried, buffer + last * kBlockBytes, buffer + end);
  }

  /// The buffer lost its first bytes. @param bytes a multiple of kBlockBytes.
  void shift(std::size_t bytes);

  /// The buffer holds other bytes.
  void reset() { known_ = 0; }

 private:
  /// Continues the running register up to block `last`, and stores it after each block.
  void run_to(const std::byte* buffer, std::size_t last) {
    std::uint32_t state = registers_[known_];
    const std::byte* next = buffer + known_ * kBlockBytes;
    std::uint16_t* to = registers_.data() + known_;
    std::size_t blocks = last - known_;
    const auto step_block = [&] {
      for (std::size_t i = 0; i < kBlockBytes; ++i) {
        state = checksum_kernels::step(state, std::to_integer<std::uint32_t>(*next++));
      }
      *++to = static_cast<std::uint16_t>(state);
    };
    for (; checksum_kernels::kLarge && blocks >= 4; blocks -= 4) {
      step_block();
      step_block();
      step_block();
      step_block();
    }
    for (; blocks > 0; --blocks) {
      step_block();
    }
    known_ = last;
  }

  /// registers_[i]: the running register before buffer[i * kBlockBytes], for i up to known_. The start value and the
  /// start position of the run do not matter.
  std::array<std::uint16_t, kMaxBufferBytes / kBlockBytes + 1> registers_{};
  std::size_t known_ = 0;
};

}  // namespace m100::mavlink
