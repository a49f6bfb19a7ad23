// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "protocol/bytes.h"
#include "protocol/crc_kernels.h"

// The inner steps of MAVLink's checksum, for inlining: CRC-16/MCRF4XX, CCITT's polynomial, reflected. Only frame.cpp
// and running_checksum.h include it.
namespace m100::mavlink::checksum_kernels {

inline constexpr std::uint32_t kStart = 0xFFFF;
inline constexpr bool kLarge = protocol::crc_kernels::kLarge;
inline constexpr std::size_t kBlockBytes = kLarge ? 1 : 4;
inline constexpr std::size_t kMaxBlocks = 272 / kBlockBytes;

/// The register after one byte, started from 0. A host uses wider entries, because it need not save their memory.
using TableEntry = std::conditional_t<kLarge, std::uint32_t, std::uint16_t>;
inline constexpr std::array<TableEntry, 256> kTable = protocol::crc_kernels::make_tables<TableEntry, 1>(0x8408)[0];

/// Inlined also where a file is compiled for size: the call would cost more than the step.
[[gnu::always_inline]] constexpr std::uint32_t step(std::uint32_t state, std::uint32_t byte) {
  return (state >> 8U) ^ kTable[(state ^ byte) & 0xFFU];
}

/// Two bytes at once: both are added to the register before the step of the first.
inline std::uint32_t step_two(std::uint32_t state, const std::byte* bytes) {
  return step(step(state ^ protocol::load<std::uint16_t>(bytes), 0), 0);
}

/// The register after the bytes in [next, last), fewer than a block (so none where a block is one byte).
inline std::uint32_t step_rest(std::uint32_t state, const std::byte* next, const std::byte* last) {
  for (; kBlockBytes > 1 && next != last; ++next) {
    state = step(state, std::to_integer<std::uint32_t>(*next));
  }
  return state;
}

constexpr std::uint32_t after_block_of_zeros(std::uint32_t state) {
  for (std::size_t byte = 0; byte < kBlockBytes; ++byte) {
    state = step(state, 0);
  }
  return state;
}

/// powers[m]: the factor by which m blocks of zeros multiply the register. Bit 15 is the coefficient of x^0.
inline constexpr auto kPowers = [] {
  std::array<std::uint16_t, kMaxBlocks + 1> powers{};
  std::uint32_t power = 0x8000;
  for (std::uint16_t& entry : powers) {
    entry = static_cast<std::uint16_t>(power);
    power = after_block_of_zeros(power);
  }
  return powers;
}();

/// a * b modulo the polynomial, both reflected. Each factor is split into four numbers that use every fourth bit, so
/// that the at most four products of a bit stay inside its four bits, and the lowest of them is correct. Written out,
/// because the loop over them costs four times as much where a file is compiled for size.
constexpr std::uint32_t multiply(std::uint32_t a, std::uint32_t b) {
  constexpr std::uint32_t kMask = 0x11111111;
  const std::uint32_t a0 = a & kMask, a1 = a & (kMask << 1U), a2 = a & (kMask << 2U), a3 = a & (kMask << 3U);
  const std::uint32_t b0 = b & kMask, b1 = b & (kMask << 1U), b2 = b & (kMask << 2U), b3 = b & (kMask << 3U);
  const std::uint32_t product = (((a0 * b0) ^ (a1 * b3) ^ (a2 * b2) ^ (a3 * b1)) & kMask) |
                                (((a0 * b1) ^ (a1 * b0) ^ (a2 * b3) ^ (a3 * b2)) & (kMask << 1U)) |
                                (((a0 * b2) ^ (a1 * b1) ^ (a2 * b0) ^ (a3 * b3)) & (kMask << 2U)) |
                                (((a0 * b3) ^ (a1 * b2) ^ (a2 * b1) ^ (a3 * b0)) & (kMask << 3U));
  const std::uint32_t aligned = product << 1U;
  return (aligned >> 16U) ^ step(step(aligned & 0xFFFFU, 0), 0);
}

/// tables[m][k][n]: the register after m blocks of zeros, if it held only nibble n at place k before. 34 KiB, on hosts
/// only.
inline constexpr auto kNibbles = [] {
  std::array<std::array<std::array<std::uint16_t, 16>, 4>, kLarge ? kMaxBlocks + 1 : 0> tables{};
  for (std::uint32_t bit = 0; kLarge && bit < 16; ++bit) {
    std::uint32_t state = std::uint32_t{1} << bit;
    for (auto& table : tables) {
      const std::size_t first = std::size_t{1} << (bit % 4);
      for (std::size_t i = 0; i < first; ++i) {
        table[bit / 4][first + i] = static_cast<std::uint16_t>(table[bit / 4][i] ^ state);
      }
      state = after_block_of_zeros(state);
    }
  }
  return tables;
}();

/// The register after `blocks` blocks of zeros, at most kMaxBlocks.
inline std::uint32_t advance(std::uint32_t state, std::size_t blocks) {
  if constexpr (kLarge) {
    const auto& table = kNibbles[blocks];
    return static_cast<std::uint32_t>(table[0][state & 0xFU] ^ table[1][(state >> 4U) & 0xFU] ^
                                      table[2][(state >> 8U) & 0xFU] ^ table[3][state >> 12U]);
  } else {
    return multiply(state, kPowers[blocks]);
  }
}

}  // namespace m100::mavlink::checksum_kernels
