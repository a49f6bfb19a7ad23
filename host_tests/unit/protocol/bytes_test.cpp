// SPDX-License-Identifier: BSD-3-Clause
// The basis of every message: reading and writing up to the end and beyond it, and opening a frame.
#include "protocol/bytes.h"

#include <gtest/gtest.h>

#include <vector>

#include "protocol/dji/frame.h"

namespace m100::protocol {
namespace {

constexpr std::array<std::byte, 5> kBytes{std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}, std::byte{5}};

TEST(ByteReader, ReadsUpToTheEnd) {
  ByteReader reader(kBytes);
  EXPECT_EQ(reader.take<std::uint32_t>(), 0x04030201U);
  EXPECT_FALSE(reader.complete()) << "a byte is left";
  EXPECT_EQ(reader.rest().size(), 1U);
  EXPECT_EQ(reader.take<std::uint8_t>(), 5);
  EXPECT_TRUE(reader.ok() && reader.complete());
}

// Would catch a decoder that reads bytes after the end of the message.
TEST(ByteReader, GivesZerosBehindTheEndForGood) {
  ByteReader reader{std::span(kBytes).first(3)};
  EXPECT_EQ(reader.take<std::uint32_t>(), 0U);
  EXPECT_FALSE(reader.ok() || reader.complete());
  EXPECT_EQ(reader.take<std::uint8_t>(), 0) << "not the first byte that was there";
  std::array<std::uint8_t, 2> more{7, 7};
  reader.take(more);
  EXPECT_EQ(more, (std::array<std::uint8_t, 2>{0, 0}));
  EXPECT_FALSE(reader.ok());
}

TEST(ByteWriter, WritesWhatFitsAndNothingElse) {
  std::array<std::byte, 5> space{};
  ByteWriter writer(space);
  writer.put(std::uint32_t{0x04030201});
  EXPECT_TRUE(writer.ok());
  writer.put(std::uint16_t{0x0605});
  EXPECT_FALSE(writer.ok());
  EXPECT_EQ(writer.size(), 4U);
  EXPECT_EQ(space[4], std::byte{0});
  writer.put(std::span<const std::byte>(kBytes).first(2));
  EXPECT_EQ(writer.size(), 4U);
  writer.put(std::span<const std::byte>(kBytes).last(1));
  EXPECT_EQ(writer.size(), 5U) << "what fits is written all the same";
  EXPECT_FALSE(writer.ok()) << "for good";
  EXPECT_TRUE(std::equal(kBytes.begin(), kBytes.end(), writer.written().begin()));
  ByteWriter empty{std::span<std::byte>{}};
  empty.put(std::span<const std::byte>{});
  EXPECT_TRUE(empty.ok());
}

/// Decrypts by adding one to each byte.
struct PlusOne final : Cipher {
  void encrypt(CipherBlock) const override {}
  void decrypt(CipherBlock block) const override {
    for (std::byte& value : block) {
      value = static_cast<std::byte>(std::to_integer<unsigned>(value) + 1U);
    }
  }
};

FrameView encrypted(std::span<const std::byte> data, std::uint8_t padding) {
  FrameView frame;
  frame.header.encryption = 1;
  frame.header.padding_bytes = padding;
  frame.data = data;
  return frame;
}

TEST(OpenFrame, RefusesWhatItCannotDecrypt) {
  CipherScratch scratch;
  const PlusOne cipher;
  const std::vector<std::byte> data(scratch.size() + 16);
  const auto opened = [&](std::size_t size, std::uint8_t padding) {
    return open(encrypted(std::span(data).first(size), padding), &cipher, scratch).status();
  };
  EXPECT_EQ(open(encrypted(std::span(data).first(16), 0), nullptr, scratch).status(), core::Status::kUnavailable);
  EXPECT_EQ(opened(15, 0), core::Status::kInvalidArgument);
  EXPECT_EQ(opened(17, 0), core::Status::kInvalidArgument);
  EXPECT_EQ(opened(16, 17), core::Status::kInvalidArgument) << "more filler than data";
  EXPECT_EQ(opened(16, 16), core::Status::kOk);
  EXPECT_EQ(opened(scratch.size(), 0), core::Status::kOk);
  EXPECT_EQ(opened(scratch.size() + 16, 0), core::Status::kInvalidArgument);
}

TEST(OpenFrame, SplitsIdValueAndFiller) {
  CipherScratch scratch;
  const PlusOne cipher;
  const std::vector<std::byte> data(32, std::byte{4});
  const auto message = open(encrypted(data, 10), &cipher, scratch);
  ASSERT_TRUE(message);
  EXPECT_TRUE(message->has_id);
  EXPECT_EQ(message->id, (MessageId{5, 5}));
  EXPECT_EQ(message->value.size(), 20U);
  EXPECT_EQ(message->value[19], std::byte{5}) << "the second block is decrypted too";
  EXPECT_EQ(message->filler.size(), 10U);
  const auto short_one = open(encrypted(std::span(data).first(16), 15), &cipher, scratch);
  ASSERT_TRUE(short_one);
  EXPECT_FALSE(short_one->has_id) << "one byte is no id";
  EXPECT_EQ(short_one->value.size(), 1U);
  const auto just_an_id = open(encrypted(std::span(data).first(16), 14), &cipher, scratch);
  ASSERT_TRUE(just_an_id);
  EXPECT_TRUE(just_an_id->has_id);
  EXPECT_TRUE(just_an_id->value.empty());
}

}  // namespace
}  // namespace m100::protocol
