// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "protocol/bytes.h"
#include "protocol/dji/frame.h"

// Finds the places of a stream where a header may begin, by its constant bytes. Only frame_parser.cpp includes it.
namespace m100::protocol::header_search {

inline constexpr std::ptrdiff_t kHeader = kHeaderBytes;
inline constexpr auto kStartNumber = std::to_integer<unsigned>(kStartByte);

/// Eight bytes at a time: bit 7 of each byte of the result tells whether that byte of the word is zero.
inline constexpr std::uint64_t kLowBits = 0x7F7F7F7F7F7F7F7FU;
constexpr std::uint64_t zero_bytes(std::uint64_t word) { return ~(((word & kLowBits) + kLowBits) | word | kLowBits); }
inline constexpr std::uint64_t kOnes = 0x0101010101010101U;
inline constexpr std::uint64_t kNotFirst = ~std::uint64_t{0xFF};
inline constexpr std::uint64_t kStartBytes = kOnes * std::to_integer<std::uint64_t>(kStartByte);
inline constexpr std::ptrdiff_t kWord = 8;
/// Bytes that must be there to judge the places of a word: the last place needs room for a header.
inline constexpr std::ptrdiff_t kRoomForWord = kWord - 1 + kHeader;
/// The last of the three bytes of a header that are always zero.
inline constexpr std::ptrdiff_t kLastZero = 7;

inline const std::byte* find_start_byte(const std::byte* at, const std::byte* last) {
  const void* const start = std::memchr(at, std::to_integer<int>(kStartByte), static_cast<std::size_t>(last - at));
  return start != nullptr ? static_cast<const std::byte*>(start) : last;
}

/// Mask of the fixed bits in the first eight bytes of a header: the start byte, and VER, RES0, RES1, which are zero.
inline constexpr std::uint64_t kFixedBits = 0xFFFFFF00C0FC00FFU;

inline bool fixed_bits_hold(const std::byte* at) {
  return (load<std::uint64_t>(at) & kFixedBits) == std::to_integer<std::uint64_t>(kStartByte);
}

}  // namespace m100::protocol::header_search
