// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/bytes.h"

// The table and the loop of a reflected CRC of at most 32 bits: for DJI's two checksums and MAVLink's.
namespace m100::protocol {

/// The register after each byte, started from 0.
template <typename T>
constexpr std::array<T, 256> make_crc_table(T polynomial) {
  std::array<T, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    T state = static_cast<T>(byte);
    for (int bit = 0; bit < 8; ++bit) {
      state = static_cast<T>((state & 1U) != 0 ? (state >> 1U) ^ polynomial : state >> 1U);
    }
    table[byte] = state;
  }
  return table;
}

template <typename T>
[[gnu::always_inline]] constexpr std::uint32_t step_crc(const std::array<T, 256>& table, std::uint32_t state,
                                                        std::uint32_t byte) {
  return table[(state ^ byte) & 0xFFU] ^ (state >> 8U);
}

/// The register after more bytes. Four are added to it at once, which saves three of four loads; each step then moves
/// the next of them down.
template <typename T>
inline std::uint32_t continue_crc(const std::array<T, 256>& table, std::uint32_t state,
                                  std::span<const std::byte> bytes) {
  const std::byte* next = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= 4; next += 4, left -= 4) {
    state ^= load<std::uint32_t>(next);
    state = step_crc(table, state, 0);
    state = step_crc(table, state, 0);
    state = step_crc(table, state, 0);
    state = step_crc(table, state, 0);
  }
  for (; left > 0; ++next, --left) {
    state = step_crc(table, state, std::to_integer<std::uint32_t>(*next));
  }
  return state;
}

}  // namespace m100::protocol
