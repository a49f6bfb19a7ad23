// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/core/assert.h"
#include "protocol/bytes.h"
#include "protocol/crc.h"

// The tables behind crc.h, and its inner steps for inlining: crc.cpp and the parser include this, nobody else should.
namespace m100::protocol::crc_kernels {

inline constexpr std::size_t kSlices = M100_CRC_SLICES;
static_assert(kSlices == 1 || kSlices == 16);
inline constexpr std::size_t kSlices16 = kSlices == 1 ? 1 : 10;
inline constexpr std::size_t kMaxZeros = 1023;

/// tables[k][b]: the register after byte b and k zero bytes, started from 0.
template <typename T, std::size_t kCount>
constexpr std::array<std::array<T, 256>, kCount> make_tables(T polynomial) {
  std::array<std::array<T, 256>, kCount> tables{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    T state = static_cast<T>(byte);
    for (int bit = 0; bit < 8; ++bit) {
      state = static_cast<T>((state & 1U) != 0 ? (state >> 1U) ^ polynomial : state >> 1U);
    }
    tables[0][byte] = state;
  }
  for (std::size_t slice = 1; slice < kCount; ++slice) {
    for (unsigned byte = 0; byte < 256; ++byte) {
      const T previous = tables[slice - 1][byte];
      tables[slice][byte] = static_cast<T>(tables[0][previous & 0xFFU] ^ (previous >> 8U));
    }
  }
  return tables;
}

inline constexpr auto kTables16 = make_tables<std::uint16_t, kSlices16>(0xA001);
inline constexpr auto kTables32 = make_tables<std::uint32_t, kSlices>(0xEDB88320);

constexpr std::uint32_t step(std::uint32_t state, std::uint32_t byte) {
  return kTables32[0][(state ^ byte) & 0xFFU] ^ (state >> 8U);
}

/// The part of a new register that a word of four bytes makes when `base` bytes follow it.
inline std::uint32_t slice(std::uint32_t word, std::size_t base) {
  return kTables32[base + 3][word & 0xFFU] ^ kTables32[base + 2][(word >> 8U) & 0xFFU] ^
         kTables32[base + 1][(word >> 16U) & 0xFFU] ^ kTables32[base][word >> 24U];
}

inline std::uint32_t step_block(std::uint32_t state, const std::byte* bytes) {
  if constexpr (kSlices == 16) {
    return slice(load<std::uint32_t>(bytes) ^ state, 12) ^ slice(load<std::uint32_t>(bytes + 4), 8) ^
           slice(load<std::uint32_t>(bytes + 8), 4) ^ slice(load<std::uint32_t>(bytes + 12), 0);
  } else {
    for (std::size_t i = 0; i < kCrc32BlockBytes; ++i) {
      state = step(state, std::to_integer<std::uint32_t>(bytes[i]));
    }
    return state;
  }
}

constexpr std::uint32_t four_zeros(std::uint32_t state) {
  if constexpr (kSlices == 16) {
    return kTables32[3][state & 0xFFU] ^ kTables32[2][(state >> 8U) & 0xFFU] ^ kTables32[1][(state >> 16U) & 0xFFU] ^
           kTables32[0][state >> 24U];
  } else {
    return step(step(step(step(state, 0), 0), 0), 0);
  }
}

/// Product without carries of two 32-bit numbers. Each factor is cut into four with one bit in four, so that a sum of
/// at most eight products stays inside its four bits and never disturbs the lowest of them.
constexpr std::uint64_t multiply_without_carries(std::uint32_t a, std::uint32_t b) {
  constexpr std::uint32_t kMask = 0x11111111U;
  constexpr std::uint64_t kWideMask = 0x1111111111111111U;
  const std::array<std::uint64_t, 4> left{a & kMask, a & (kMask << 1U), a & (kMask << 2U), a & (kMask << 3U)};
  const std::array<std::uint64_t, 4> right{b & kMask, b & (kMask << 1U), b & (kMask << 2U), b & (kMask << 3U)};
  const std::uint64_t low = (left[0] * right[0]) ^ (left[1] * right[3]) ^ (left[2] * right[2]) ^ (left[3] * right[1]);
  const std::uint64_t second =
      (left[0] * right[1]) ^ (left[1] * right[0]) ^ (left[2] * right[3]) ^ (left[3] * right[2]);
  const std::uint64_t third = (left[0] * right[2]) ^ (left[1] * right[1]) ^ (left[2] * right[0]) ^ (left[3] * right[3]);
  const std::uint64_t high = (left[0] * right[3]) ^ (left[1] * right[2]) ^ (left[2] * right[1]) ^ (left[3] * right[0]);
  return (low & kWideMask) | (second & (kWideMask << 1U)) | (third & (kWideMask << 2U)) | (high & (kWideMask << 3U));
}

/// a * b mod P, both reflected: bit 31 is the coefficient of x^0.
constexpr std::uint32_t multiply_mod(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t product = multiply_without_carries(a, b) << 1U;
  return static_cast<std::uint32_t>(product >> 32U) ^ four_zeros(static_cast<std::uint32_t>(product));
}

inline constexpr std::uint32_t kOne = 0x80000000U;

/// x^(8 i) mod P for i < 32, and x^(8 * 32 i): any power up to 1023 is a product of two.
constexpr std::array<std::array<std::uint32_t, 32>, 2> make_powers() {
  std::array<std::array<std::uint32_t, 32>, 2> powers{};
  std::uint32_t power = kOne;
  for (std::uint32_t& entry : powers[0]) {
    entry = power;
    power = step(power, 0);
  }
  const std::uint32_t coarse = power;  // x^(8 * 32)
  power = kOne;
  for (std::uint32_t& entry : powers[1]) {
    entry = power;
    power = multiply_mod(power, coarse);
  }
  return powers;
}

inline constexpr auto kPowers = make_powers();

/// With slicing tables, 4 KiB more make one product out of two.
constexpr std::array<std::uint32_t, kSlices == 16 ? kMaxZeros + 1 : 1> make_all_powers() {
  std::array<std::uint32_t, kSlices == 16 ? kMaxZeros + 1 : 1> powers{};
  std::uint32_t power = kOne;
  for (std::uint32_t& entry : powers) {
    entry = power;
    power = step(power, 0);
  }
  return powers;
}

inline constexpr auto kAllPowers = make_all_powers();

/// As crc16_of_header().
inline std::uint16_t header_crc16(const std::byte* header) {
  if constexpr (kSlices16 == 10) {
    const auto first = static_cast<std::uint16_t>(load<std::uint16_t>(header) ^ kCrc16Start);
    const auto rest = load<std::uint64_t>(header + 2);
    unsigned state = kTables16[9][first & 0xFFU] ^ kTables16[8][first >> 8U];
    for (unsigned i = 0; i < 8; ++i) {
      state ^= kTables16[7 - i][(rest >> (8 * i)) & 0xFFU];
    }
    return static_cast<std::uint16_t>(state);
  } else {
    return crc16({header, 10});
  }
}

/// crc32 over fewer than 16 bytes.
inline std::uint32_t step_rest(std::uint32_t state, const std::byte* next, std::size_t count) {
  if constexpr (kSlices == 16) {
    if ((count & 8U) != 0) {
      state = slice(load<std::uint32_t>(next) ^ state, 4) ^ slice(load<std::uint32_t>(next + 4), 0);
      next += 8;
    }
    if ((count & 4U) != 0) {
      state = slice(load<std::uint32_t>(next) ^ state, 0);
      next += 4;
    }
    count &= 3U;
  }
  for (; count > 0; ++next, --count) {
    state = step(state, std::to_integer<std::uint32_t>(*next));
  }
  return state;
}

/// As crc32_advance().
inline std::uint32_t advance(std::uint32_t state, std::size_t zeros) {
  if constexpr (kSlices == 16) {
    return multiply_mod(state, kAllPowers[zeros]);
  } else {
    return multiply_mod(multiply_mod(state, kPowers[0][zeros % 32]), kPowers[1][zeros / 32]);
  }
}

/// As crc32_running().
inline void run_blocks(const std::byte* bytes, std::uint32_t* running, std::size_t blocks) {
  std::uint32_t state = *running;
  for (; blocks > 0; --blocks, bytes += kCrc32BlockBytes) {
    state = step_block(state, bytes);
    *++running = state;
  }
}

}  // namespace m100::protocol::crc_kernels
