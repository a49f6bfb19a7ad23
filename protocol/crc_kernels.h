// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "protocol/bytes.h"
#include "protocol/crc.h"

// The tables of crc.h, and its inner steps for inlining: for crc.cpp, DJI's parser, MAVLink's checksum and a test.
namespace m100::protocol::crc_kernels {

inline constexpr std::size_t kSlices = M100_CRC_SLICES;
inline constexpr bool kLarge = kSlices != 1;
static_assert(kSlices == 1 || kSlices == 8);
inline constexpr std::size_t kSlices16 = kLarge ? 10 : 1;

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

/// Four bytes at once: they are added to the register before the first step.
inline std::uint32_t step_four(std::uint32_t state, const std::byte* bytes) {
  state ^= load<std::uint32_t>(bytes);
  return step(step(step(step(state, 0), 0), 0), 0);
}

/// The register after eight bytes, started from 0. For another start value, XOR it into the first four bytes. Each turn
/// takes two bytes, because some machines can address both halves of a 16-bit register without a shift.
constexpr std::uint32_t after_eight(std::uint64_t bytes) {
  std::uint32_t state = 0;
  for (std::size_t i = 0; i < 8; i += 2) {
    state ^= kTables32[7 - i][bytes & 0xFFU] ^ kTables32[6 - i][(bytes >> 8U) & 0xFFU];
    bytes >>= 16U;
  }
  return state;
}

inline std::uint32_t step_block(std::uint32_t state, const std::byte* bytes) {
  if constexpr (kLarge) {
    return after_eight(load<std::uint64_t>(bytes) ^ state);
  } else {
    for (std::size_t i = 0; i < kCrc32BlockBytes; i += 4) {
      state = step_four(state, bytes + i);
    }
    return state;
  }
}

/// Continues a CRC32 byte by byte; where there are no slicing tables, four bytes at a time and then the rest.
inline std::uint32_t step_rest(std::uint32_t state, const std::byte* next, std::size_t count) {
  if constexpr (!kLarge) {
    for (; count >= 4; next += 4, count -= 4) {
      state = step_four(state, next);
    }
  }
  for (; count > 0; ++next, --count) {
    state = step(state, std::to_integer<std::uint32_t>(*next));
  }
  return state;
}

/// Carry-less product of two 32-bit numbers. Each factor is split into four numbers that use every fourth bit, so that
/// a sum of at most eight products stays inside its four bits, and the lowest of them is correct.
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
  const auto low = static_cast<std::uint32_t>(product);
  return static_cast<std::uint32_t>(product >> 32U) ^ step(step(step(step(low, 0), 0), 0), 0);
}

inline constexpr std::uint32_t kOne = 0x80000000U;

/// x^(8 i) mod P for i < 32, and x^(8 * 32 i): the factor of up to 1023 zero bytes is a product of two of them.
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

inline constexpr std::size_t kBlockDistances = kLarge ? 128 : 0;
using NibbleTable = std::array<std::array<std::uint32_t, 16>, 8>;

/// tables[m][k][n]: the register after m blocks of zeros, if it held only nibble n at place k before. 64 KiB.
constexpr std::array<NibbleTable, kBlockDistances> make_block_powers() {
  std::array<NibbleTable, kBlockDistances> tables{};
  for (std::size_t bit = 0; kLarge && bit < 32; ++bit) {
    std::uint32_t state = std::uint32_t{1} << bit;
    for (NibbleTable& table : tables) {
      std::array<std::uint32_t, 16>& entries = table[bit / 4];
      const std::size_t first = std::size_t{1} << (bit % 4);
      for (std::size_t i = 0; i < first; ++i) {
        entries[first + i] = entries[i] ^ state;
      }
      state = after_eight(state);
    }
  }
  return tables;
}

inline constexpr auto kBlockPowers = make_block_powers();

/// The CRC register `state` after `blocks` more blocks of zeros, blocks <= 1023 / kCrc32BlockBytes.
inline std::uint32_t advance_blocks(std::uint32_t state, std::size_t blocks) {
  if constexpr (kLarge) {
    const NibbleTable& table = kBlockPowers[blocks];
    std::uint32_t even = state & 0x0F0F0F0FU;
    std::uint32_t odd = (state >> 4U) & 0x0F0F0F0FU;
    std::uint32_t result = 0;
    for (std::size_t place = 0; place < 8; place += 4) {
      result ^= table[place][even & 0xFFU] ^ table[place + 1][odd & 0xFFU];
      result ^= table[place + 2][(even >> 8U) & 0xFFU] ^ table[place + 3][(odd >> 8U) & 0xFFU];
      even >>= 16U;
      odd >>= 16U;
    }
    return result;
  } else {
    const std::size_t zeros = blocks * kCrc32BlockBytes;
    return multiply_mod(multiply_mod(state, kPowers[0][zeros % 32]), kPowers[1][zeros / 32]);
  }
}

/// The register after the first one to eight bytes of a header; bytes 1 to 4 are looked up separately.
struct HeaderStarts {
  /// constants[c]: after c bytes, if bytes 1 to 4 were zero.
  std::array<std::uint32_t, 9> constants{};
  /// slices[8 + k] is kTables32[k]; those below are zero, so that a byte beyond the count has no effect.
  std::array<std::array<std::uint32_t, 256>, kLarge ? 16 : 1> slices{};
};

constexpr HeaderStarts make_header_starts(std::uint32_t start_byte) {
  HeaderStarts starts;
  std::uint32_t state = kCrc32Start;
  for (std::size_t count = 1; count < starts.constants.size(); ++count) {
    state = step(state, count == 1 ? start_byte : 0);
    starts.constants[count] = state;
  }
  for (std::size_t slice = 8; slice < starts.slices.size(); ++slice) {
    starts.slices[slice] = kTables32[slice - 8];
  }
  return starts;
}

template <unsigned kStart>
inline constexpr HeaderStarts kHeaderStarts = make_header_starts(kStart);

/// crc32 over the first 1 to kCrc32BlockBytes bytes of a frame. Its byte 0 is kStart and its bytes 5 to 7 are zero, so
/// only four of the first eight have to be looked up.
template <unsigned kStart>
inline std::uint32_t after_header_start(const std::byte* header, std::size_t count) {
  if constexpr (kLarge) {
    const HeaderStarts& starts = kHeaderStarts<kStart>;
    const std::array<std::uint32_t, 256>* const slices = starts.slices.data() + count;
    const auto bytes = load<std::uint32_t>(header + 1);
    return starts.constants[count] ^ slices[6][bytes & 0xFFU] ^ slices[5][(bytes >> 8U) & 0xFFU] ^
           slices[4][(bytes >> 16U) & 0xFFU] ^ slices[3][bytes >> 24U];
  } else {
    return step_rest(kCrc32Start, header, count);
  }
}

/// Whether the checksum of a frame is right when `left` of its bytes remain, 1 to kCrc32BlockBytes. The last four are
/// the checksum. The register after the data must equal it; after some of its bytes, the bytes that remain.
inline bool ends_well(std::uint32_t state, const std::byte* bytes, std::size_t left) {
  constexpr std::size_t kChecksumBytes = 4;
  if (left < kChecksumBytes) {
    const std::uint32_t to_come = (std::uint32_t{1} << (8 * left)) - 1;
    return state == (load<std::uint32_t>(bytes) & to_come);
  }
  const std::size_t data = left - kChecksumBytes;
  return step_rest(state, bytes, data) == load<std::uint32_t>(bytes + data);
}

/// The register after `zeros` more bytes of value zero, zeros <= 1023: state * x^(8 zeros) mod P.
///
/// The register is linear over GF(2): feeding bytes D to the sum of two states is the sum of feeding D to one and zeros
/// to the other. With prefix(i) = register after the first i bytes of a stream, started from anything,
///   crc32(bytes a..b, start) = prefix(b) ^ advance(prefix(a) ^ start, b - a),
/// so the checksum of any range of bytes costs a constant. Cost: 8 look-ups and one more for each zero after the last
/// whole block of kCrc32BlockBytes; with small tables 10 look-ups, 32 multiplications and likewise.
inline std::uint32_t advance(std::uint32_t state, std::size_t zeros) {
  state = advance_blocks(state, zeros / kCrc32BlockBytes);
  for (std::size_t left = zeros % kCrc32BlockBytes; left > 0; --left) {
    state = step(state, 0);
  }
  return state;
}

/// crc16() over the 10 bytes that start at header: with slicing tables the look-ups are independent of each other.
inline std::uint16_t header_crc16(const std::byte* header) {
  if constexpr (kLarge) {
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

/// header_crc16 for a header whose byte 0 is `start` and whose bytes 5 to 7 are zero: these bytes cost nothing.
template <unsigned kStart>
inline std::uint16_t usual_header_crc16(const std::byte* header) {
  if constexpr (kLarge) {
    constexpr unsigned kBegin = kTables16[9][(kStart ^ kCrc16Start) & 0xFFU];
    const auto first = load<std::uint32_t>(header + 1) ^ (kCrc16Start >> 8U);
    const auto sequence = load<std::uint16_t>(header + 8);
    return static_cast<std::uint16_t>(kBegin ^ kTables16[8][first & 0xFFU] ^ kTables16[7][(first >> 8U) & 0xFFU] ^
                                      kTables16[6][(first >> 16U) & 0xFFU] ^ kTables16[5][first >> 24U] ^
                                      kTables16[1][sequence & 0xFFU] ^ kTables16[0][sequence >> 8U]);
  } else {
    return header_crc16(header);
  }
}

/// Continues a running CRC32 block by block: running[i + 1] is running[i] after the i-th block of bytes.
inline void run_blocks(const std::byte* bytes, std::uint32_t* running, std::size_t blocks) {
  std::uint32_t state = *running;
  for (; blocks > 0; --blocks, bytes += kCrc32BlockBytes) {
    state = step_block(state, bytes);
    *++running = state;
  }
}

}  // namespace m100::protocol::crc_kernels
