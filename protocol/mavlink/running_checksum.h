// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "protocol/crc_table.h"

namespace m100::mavlink {

/// CRC-16/MCRF4XX: CCITT's polynomial, reflected.
inline constexpr std::uint16_t kChecksumStart = 0xFFFF;
inline constexpr auto kChecksumTable = protocol::make_crc_table<std::uint16_t>(0x8408);

/// The MAVLink checksum of any range of a buffer, at a cost that does not depend on the length of the range.
///
/// Each byte of the buffer enters one running register at most once. The register is linear over GF(2): feeding bytes D
/// to the sum of two states is the sum of feeding D to one and zeros to the other. So the difference of two runs over
/// the same bytes changes with their number alone, and with run(i) = the running register before byte i, started from
/// anything,
///   checksum(bytes a..b) = run(b) ^ (run(a) ^ start) x^(8 (b - a)) mod P.
class RunningChecksum {
 public:
  static constexpr std::size_t kMaxBufferBytes = 512;
  static constexpr std::size_t kMaxRangeBytes = 272;

  /// The checksum of buffer[begin] to buffer[end - 1], at most kMaxRangeBytes bytes. The begins of successive calls
  /// must not decrease.
  std::uint32_t of_range(const std::byte* buffer, std::size_t begin, std::size_t end) {
    if (known_ < begin) {  // no earlier range needs the bytes in between: the run starts again behind them
      known_ = begin;
      registers_[begin] = kChecksumStart;
    }
    std::uint32_t state = registers_[known_];
    for (; known_ < end; registers_[++known_] = static_cast<std::uint16_t>(state)) {
      state = protocol::step_crc(kChecksumTable, state, std::to_integer<std::uint32_t>(buffer[known_]));
    }
    const auto apart = static_cast<std::uint32_t>(registers_[begin] ^ kChecksumStart);
    return registers_[end] ^ (apart != 0 ? multiply(apart, kPowers[end - begin]) : 0);
  }

  /// The buffer lost its first bytes.
  void shift(std::size_t bytes) {
    known_ = known_ > bytes ? known_ - bytes : 0;
    std::memmove(registers_.data(), registers_.data() + bytes, (known_ + 1) * sizeof(registers_[0]));
  }

  /// The buffer holds other bytes.
  void reset() { known_ = 0; }

 private:
  /// powers[n]: x^(8 n) mod P, the factor by which n zeros multiply the register. Bit 15 is the coefficient of x^0.
  static constexpr auto kPowers = [] {
    std::array<std::uint16_t, kMaxRangeBytes + 1> powers{};
    std::uint32_t power = 0x8000;
    for (std::uint16_t& entry : powers) {
      entry = static_cast<std::uint16_t>(power);
      power = protocol::step_crc(kChecksumTable, power, 0);
    }
    return powers;
  }();

  /// a * b modulo the polynomial, both reflected. Each factor is split into four numbers that use every fourth bit, so
  /// that the at most four products of a bit stay inside its four bits, and the lowest of them is correct.
  static constexpr std::uint32_t multiply(std::uint32_t a, std::uint32_t b) {
    constexpr std::uint32_t kMask = 0x11111111;
    const std::uint32_t a0 = a & kMask, a1 = a & (kMask << 1U), a2 = a & (kMask << 2U), a3 = a & (kMask << 3U);
    const std::uint32_t b0 = b & kMask, b1 = b & (kMask << 1U), b2 = b & (kMask << 2U), b3 = b & (kMask << 3U);
    const std::uint32_t product = (((a0 * b0) ^ (a1 * b3) ^ (a2 * b2) ^ (a3 * b1)) & kMask) |
                                  (((a0 * b1) ^ (a1 * b0) ^ (a2 * b3) ^ (a3 * b2)) & (kMask << 1U)) |
                                  (((a0 * b2) ^ (a1 * b1) ^ (a2 * b0) ^ (a3 * b3)) & (kMask << 2U)) |
                                  (((a0 * b3) ^ (a1 * b2) ^ (a2 * b1) ^ (a3 * b0)) & (kMask << 3U));
    const std::uint32_t aligned = product << 1U;
    const std::uint32_t half = protocol::step_crc(kChecksumTable, aligned & 0xFFFFU, 0);
    return (aligned >> 16U) ^ protocol::step_crc(kChecksumTable, half, 0);
  }

  /// registers_[i]: the running register before buffer[i], for i up to known_.
  std::array<std::uint16_t, kMaxBufferBytes + 1> registers_{};
  std::size_t known_ = 0;
};

}  // namespace m100::mavlink
