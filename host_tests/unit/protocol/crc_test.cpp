// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/crc.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>
#include <vector>

namespace m100::protocol {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

std::vector<std::byte> random_bytes(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> bytes(count);
  for (std::byte& byte : bytes) {
    byte = static_cast<std::byte>(random() & 0xFFU);
  }
  return bytes;
}

/// The CRC by its definition, bit by bit.
std::uint32_t slow_crc(std::span<const std::byte> bytes, std::uint32_t state, std::uint32_t polynomial) {
  for (const std::byte byte : bytes) {
    state ^= std::to_integer<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) {
      state = (state & 1U) != 0 ? (state >> 1U) ^ polynomial : state >> 1U;
    }
  }
  return state;
}

// The check values of the protocol description. Catches a wrong start value, reflection or final XOR.
TEST(Crc, GivesTheCheckValues) {
  EXPECT_EQ(crc16(bytes_of("123456789")), 0x2752);
  EXPECT_EQ(crc32(bytes_of("123456789")), 0xE4D9DC14U);
}

// Catches a wrong table, or a rest after the last four bytes that is lost, for any length and remainder.
TEST(Crc, AgreesWithTheDefinitionForEveryLength) {
  const std::vector<std::byte> bytes = random_bytes(100, 1);
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    const std::span<const std::byte> part = std::span(bytes).first(size);
    ASSERT_EQ(crc32(part), slow_crc(part, kCrc32Start, 0xEDB88320U)) << size;
    ASSERT_EQ(crc16(part), slow_crc(part, kCrc16Start, 0xA001U)) << size;
  }
}

}  // namespace
}  // namespace m100::protocol
