// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/crc.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>
#include <vector>

#include "protocol/crc_kernels.h"

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

// Catches a slicing table that is off by one, for any length and remainder.
TEST(Crc, AgreesWithTheDefinitionForEveryLength) {
  const std::vector<std::byte> bytes = random_bytes(100, 1);
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    const std::span<const std::byte> part = std::span(bytes).first(size);
    ASSERT_EQ(crc32(part), slow_crc(part, kCrc32Start, 0xEDB88320U)) << size;
    ASSERT_EQ(crc16(part), slow_crc(part, kCrc16Start, 0xA001U)) << size;
  }
}

TEST(Crc, OfAHeaderIsTheCrcOfTenBytes) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const std::vector<std::byte> bytes = random_bytes(10, seed);
    ASSERT_EQ(crc_kernels::header_crc16(bytes.data()), crc16(bytes)) << seed;
  }
}

TEST(Crc, RunsFromBlockToBlock) {
  const std::vector<std::byte> bytes = random_bytes(160, 2);
  std::vector<std::uint32_t> running(11, 77U);
  crc_kernels::run_blocks(bytes.data(), running.data(), running.size() - 1);
  for (std::size_t block = 0; block < running.size(); ++block) {
    EXPECT_EQ(running[block], crc32(std::span(bytes).first(block * kCrc32BlockBytes), 77U)) << block;
  }
}

// Catches a wrong power or a carry in the product: every distance is compared with feeding zeros.
TEST(Crc, AdvanceEqualsFeedingZeros) {
  const std::vector<std::byte> zeros(1023);
  for (const std::uint32_t state : {1U, 0x80000000U, 0xFFFFFFFFU, 0x12345678U, 0U}) {
    for (std::size_t count = 0; count <= zeros.size(); ++count) {
      ASSERT_EQ(crc_kernels::advance(state, count), crc32(std::span(zeros).first(count), state))
          << state << ' ' << count;
    }
  }
}

// The parser relies on this identity.
TEST(Crc, OfAnyStretchFollowsFromTwoRunningValues) {
  const std::vector<std::byte> bytes = random_bytes(1200, 7);
  std::vector<std::uint32_t> running{0xDEADBEEFU};
  for (const std::byte& byte : bytes) {
    running.push_back(crc32({&byte, 1}, running.back()));
  }
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    const std::size_t from = random() % bytes.size();
    const std::size_t size = random() % (std::min<std::size_t>(1023, bytes.size() - from) + 1);
    ASSERT_EQ(running[from + size] ^ crc_kernels::advance(running[from] ^ kCrc32Start, size),
              crc32(std::span(bytes).subspan(from, size)));
  }
}

}  // namespace
}  // namespace m100::protocol
