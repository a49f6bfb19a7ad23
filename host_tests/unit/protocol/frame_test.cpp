// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/dji/frame.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "protocol/aes256.h"
#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/frame_parser.h"

namespace m100::protocol {
namespace {

constexpr CipherKey kKey{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 0x80, 0xFF};
using Space = std::array<std::byte, kMaxFrameBytes>;

std::vector<std::byte> counting_bytes(std::size_t count) {
  std::vector<std::byte> bytes(count);
  for (std::size_t i = 0; i < count; ++i) {
    bytes[i] = static_cast<std::byte>(i * 7 + 1);
  }
  return bytes;
}

// Catches a length, padding or checksum that is wrong for some size of DATA, plain or encrypted.
TEST(Frame, EverySizeComesBackAsItWent) {
  const Aes256 cipher(kKey);
  for (const bool encrypted : {false, true}) {
    const std::size_t longest = (encrypted ? 991 : kMaxDataBytes) - kMessageIdBytes;
    for (std::size_t size = 0; size <= longest; ++size) {
      Space space;
      const std::vector<std::byte> value = counting_bytes(size);
      const MessageId id{1, 3};
      const auto bytes =
          encode_frame({.session = 7, .encrypted = encrypted, .sequence = 0xBEEF}, &id, value, space, &cipher);
      ASSERT_TRUE(bytes) << size;
      FrameParser parser;
      ASSERT_EQ(parser.push(*bytes), bytes->size());
      const auto frame = parser.poll();
      ASSERT_TRUE(frame) << size;
      CipherScratch scratch;
      const auto message = open(*frame, &cipher, scratch);
      ASSERT_TRUE(message) << size;
      EXPECT_EQ(message->id, id);
      EXPECT_EQ(message->header.session, 7);
      EXPECT_EQ(message->header.sequence, 0xBEEF);
      ASSERT_EQ(std::vector<std::byte>(message->value.begin(), message->value.end()), value) << size;
    }
  }
}

// The block of FIPS-197, appendix C.3. Catches a swapped key schedule.
TEST(Frame, CipherIsAes256) {
  CipherKey key;
  std::array<std::byte, 16> block;
  for (std::size_t i = 0; i < key.size(); ++i) {
    key[i] = static_cast<std::uint8_t>(i);
  }
  for (std::size_t i = 0; i < block.size(); ++i) {
    block[i] = static_cast<std::byte>(i * 0x11);
  }
  const std::array<std::byte, 16> plain = block;
  const Aes256 cipher(key);
  cipher.encrypt(block);
  EXPECT_EQ(block[0], std::byte{0x8E});
  EXPECT_EQ(block[1], std::byte{0xA2});
  EXPECT_EQ(block[15], std::byte{0x89});
  cipher.decrypt(block);
  EXPECT_EQ(block, plain);
}

struct BadFrame {
  const char* name;
  Envelope envelope;
  std::size_t value_bytes;
  std::size_t space_bytes;
  core::Status status;
};

class FrameEncoderRefuses : public ::testing::TestWithParam<BadFrame> {};

TEST_P(FrameEncoderRefuses, WhatItCannotSay) {
  const BadFrame& bad = GetParam();
  std::vector<std::byte> space(bad.space_bytes);
  const std::vector<std::byte> value(bad.value_bytes);
  EXPECT_EQ(encode_frame(bad.envelope, nullptr, value, space).status(), bad.status);
}

INSTANTIATE_TEST_SUITE_P(
    Table, FrameEncoderRefuses,
    ::testing::Values(BadFrame{"SessionBeyondFiveBits", {.session = 32}, 1, 64, core::Status::kInvalidArgument},
                      BadFrame{"CipherTextOfNothing", {.encrypted = true}, 0, 64, core::Status::kInvalidArgument},
                      BadFrame{"EncryptionWithoutKey", {.encrypted = true}, 4, 64, core::Status::kUnavailable},
                      BadFrame{"MoreThanTenBitsOfLength", {}, 1008, 2000, core::Status::kOutOfRange},
                      BadFrame{"MoreThan62Blocks", {.encrypted = true}, 992, 2000, core::Status::kOutOfRange},
                      BadFrame{"NoRoom", {}, 10, 25, core::Status::kResourceExhausted}),
    [](const auto& tested) { return tested.param.name; });

// Catches a parser that counts differently, or keeps a byte back, when bytes come one by one; and one that is full and
// does not report it.
TEST(FrameParser, TakesBytesOneByOneAsItTakesThemTogether) {
  Space space;
  const std::vector<std::byte> value = counting_bytes(20);
  const MessageId id{1, 3};
  const auto bytes = encode_frame({.session = 7, .sequence = 1}, &id, value, space);
  ASSERT_TRUE(bytes);
  FrameParser together, one_by_one;
  ASSERT_EQ(together.push(*bytes), bytes->size());
  ASSERT_TRUE(together.poll());
  for (std::size_t i = 0; i < bytes->size(); ++i) {
    EXPECT_EQ(one_by_one.push((*bytes)[i]).has_value(), i + 1 == bytes->size()) << i;
    EXPECT_EQ(one_by_one.pending_bytes(), i + 1 == bytes->size() ? 0U : i + 1);
  }
  EXPECT_TRUE(one_by_one.stats() == together.stats());
  EXPECT_EQ(one_by_one.stats().frames, 1U);
  while (one_by_one.push(*bytes) == bytes->size()) {
  }
  EXPECT_EQ(one_by_one.push(std::byte{0}).status(), core::Status::kResourceExhausted);
  EXPECT_TRUE(one_by_one.poll());
}

TEST(FrameParser, ShortestFrameHasNoChecksumOfData) {
  Space space;
  const auto bytes = encode_frame({.session = 3, .is_ack = true, .sequence = 9}, nullptr, {}, space);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(bytes->size(), kHeaderBytes);
  FrameParser parser;
  ASSERT_EQ(parser.push(*bytes), kHeaderBytes);
  const auto frame = parser.poll();
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->data.empty());
  EXPECT_TRUE(frame->header.is_ack);
}

}  // namespace
}  // namespace m100::protocol
