// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/mavlink/parser.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "host_tests/property/mavlink/noise.h"
#include "host_tests/property/mavlink/streams.h"
#include "host_tests/sim/world/random.h"
#include "protocol/mavlink/messages.h"
#include "protocol/mavlink/signature.h"

namespace m100::mavlink {
namespace {

using Bytes = std::vector<std::byte>;

Frame pose(std::uint8_t sequence) {
  return encode(AttPosMocap{.time_usec = sequence, .q = {1.F, 0.F, 0.F, 0.F}, .x = 0.1F, .y = 2.F, .z = -3.F}, {9, 1},
                sequence);
}

using host_tests::mavlink_streams::append;

std::vector<std::uint8_t> sequences(Parser& parser, std::span<const std::byte> bytes, std::size_t portion) {
  std::vector<std::uint8_t> found;
  for (std::size_t at = 0; at < bytes.size(); at += portion) {
    parser.consume(bytes.subspan(at, std::min(portion, bytes.size() - at)),
                   [&](const FrameView& frame) { found.push_back(frame.sequence); });
  }
  return found;
}

// Catches a running checksum that is carried over the wrong number of bytes, restarted at a wrong place, or stale after
// the buffer moved: a receiver that sums each claimed frame anew must find the same frames and refuse the same headers.
TEST(MavlinkParser, FindsWhatAReceiverFindsThatSumsEveryClaimAnew) {
  RecordProperty("promise", "R2");
  namespace streams = host_tests::mavlink_streams;
  std::mt19937 random(36);
  std::size_t frames = 0;
  for (int round = 0; round < 1000; ++round) {
    Bytes stream;
    const std::size_t pieces = 1 + random() % 4;
    for (std::size_t piece = 0; piece < pieces; ++piece) {
      constexpr std::array kKinds{streams::pattern, streams::headers, streams::frames_among_headers,
                                  streams::frames_among_headers};
      append(stream, kKinds.at(random() % kKinds.size())(random, 200 + random() % 2000));
      if (random() % 8 == 0) {
        append(stream, streams::densest_headers(random() % 600));
      }
    }
    if (random() % 2 == 0) {
      stream[random() % stream.size()] ^= std::byte{1} << (random() % 8);
    }
    const streams::Reference wanted = streams::reference_parse(stream);
    for (const std::size_t portion : {std::size_t{1}, 1 + std::size_t{random() % 300}, stream.size()}) {
      Parser parser;
      std::vector<std::uint64_t> found;
      for (std::size_t at = 0; at < stream.size(); at += portion) {
        parser.consume(std::span(stream).subspan(at, std::min(portion, stream.size() - at)),
                       [&](const FrameView& frame) { found.push_back(frame.offset); });
      }
      ASSERT_EQ(found, wanted.offsets) << "round " << round << ", portions of " << portion;
      EXPECT_EQ(parser.stats().crc_errors, wanted.crc_errors) << "round " << round << ", portions of " << portion;
    }
    frames += wanted.offsets.size();
  }
  EXPECT_GT(frames, 5000U) << "too few good frames for a test";
}

// Catches a parser that drops a good frame together with the false header whose claim covers it, wholly or in part.
TEST(MavlinkParser, AFrameInsideTheClaimOfFalseHeadersIsFoundWhereverItLies) {
  const Frame good = pose(7);
  for (std::size_t before = 0; before < 300; ++before) {
    Bytes stream{kStart2,      std::byte{0xFF}, std::byte{0},   std::byte{0}, std::byte{0},
                 std::byte{0}, std::byte{0},    std::byte{138}, std::byte{0}, std::byte{0}};
    append(stream, host_tests::mavlink_streams::densest_headers(before));
    append(stream, good.bytes());
    stream.resize(stream.size() + kMaxFrameBytes);
    Parser parser;
    ASSERT_EQ(sequences(parser, stream, 1 + before % 97), std::vector<std::uint8_t>{7}) << before;
  }
}

// Misleading garbage: start bytes of both versions, and headers of known messages that claim the longest frame.
Bytes garbage(sim::Random& random, std::size_t count) {
  Bytes bytes;
  while (bytes.size() < count) {
    switch (random.next() % 6) {
      case 0:
        bytes.push_back(kStart2);
        break;
      case 1:
        bytes.push_back(kStart1);
        break;
      case 2:
        for (const unsigned value : {0xFDU, 0xFFU, 0U, 0U, 7U, 1U, 1U, 138U, 0U, 0U}) {
          bytes.push_back(static_cast<std::byte>(value));
        }
        break;
      default:
        bytes.push_back(static_cast<std::byte>(random.next() >> 56U));
    }
  }
  return bytes;
}

// Catches a parser that trusts the length of a false header and skips the bytes after it.
TEST(MavlinkParser, EveryGoodFrameAmongGarbageIsFoundHoweverTheStreamIsCut) {
  RecordProperty("promise", "R2");
  sim::Random random(5, "mavlink");
  for (int round = 0; round < 60; ++round) {
    Bytes stream;
    for (int n = 0; n < 40; ++n) {
      append(stream, garbage(random, static_cast<std::size_t>(random.next() % 60)));
      append(stream, pose(static_cast<std::uint8_t>(n)).bytes());
    }
    stream.resize(stream.size() + kMaxFrameBytes);  // clean bytes, so that no false header stays incomplete
    Parser parser;
    const std::vector<std::uint8_t> found =
        sequences(parser, stream, 1 + static_cast<std::size_t>(random.next() % 700));
    ASSERT_EQ(found.size(), 40U) << "round " << round;
    for (std::size_t n = 0; n < found.size(); ++n) {
      EXPECT_EQ(found[n], n);
    }
    EXPECT_EQ(parser.stats().bytes, stream.size());
  }
}

TEST(MavlinkParser, NoFlippedBitIsAccepted) {
  const Frame good = pose(3);
  for (std::size_t bit = 0; bit < 8 * good.size; ++bit) {
    Bytes stream(good.bytes().begin(), good.bytes().end());
    stream[bit / 8] ^= std::byte{1} << (bit % 8);
    append(stream, pose(4).bytes());
    stream.resize(stream.size() + kMaxFrameBytes);
    Parser parser;
    EXPECT_EQ(sequences(parser, stream, 13), std::vector<std::uint8_t>{4}) << "bit " << bit;
  }
}

TEST(MavlinkParser, CutShortAnywhereTheNextFrameIsFound) {
  const Frame good = pose(3);
  for (std::size_t length = 0; length < good.size; ++length) {
    Bytes stream(good.bytes().begin(), good.bytes().begin() + static_cast<std::ptrdiff_t>(length));
    append(stream, pose(4).bytes());
    append(stream, pose(5).bytes());
    stream.resize(stream.size() + kMaxFrameBytes);
    Parser parser;
    EXPECT_EQ(sequences(parser, stream, 1), (std::vector<std::uint8_t>{4, 5})) << length;
  }
}

TEST(MavlinkParser, UnknownAndIncompatibleFramesAreCountedAndTheNextIsFound) {
  Bytes stream;
  append(stream, pose(1).bytes());
  Frame unknown = pose(2);
  unknown.space[7] = std::byte{200};
  append(stream, unknown.bytes());
  append(stream, pose(3).bytes());
  Frame flagged = pose(4);
  flagged.space[2] = std::byte{0x02};  // an incompatible flag: a receiver that does not know it must drop the frame
  append(stream, flagged.bytes());
  append(stream, pose(5).bytes());
  Parser parser;
  EXPECT_EQ(sequences(parser, stream, 9), (std::vector<std::uint8_t>{1, 3, 5}));
  EXPECT_EQ(parser.stats().unknown, 1U);
  EXPECT_EQ(parser.stats().incompatible, 1U);
}

TEST(MavlinkParser, VersionOneIsReadToo) {
  const AttPosMocap message{.time_usec = 77, .q = {1.F, 0.F, 0.F, 0.F}, .x = 4.F};
  std::array<std::byte, AttPosMocap::kInfo.full_bytes> payload;
  encode_payload(message, payload);
  Bytes frame{kStart1, std::byte{36}, std::byte{8}, std::byte{9}, std::byte{1}, std::byte{138}};
  append(frame, std::span(payload).first(36));
  const std::byte extra{AttPosMocap::kInfo.crc_extra};
  const std::uint16_t sum = checksum(std::span(&extra, 1), checksum(std::span(frame).subspan(1)));
  frame.push_back(static_cast<std::byte>(sum & 0xFFU));
  frame.push_back(static_cast<std::byte>(sum >> 8U));
  Parser parser;
  std::size_t found = 0;
  parser.consume(frame, [&](const FrameView& view) {
    ++found;
    EXPECT_EQ(view.version, 1);
    EXPECT_EQ(decode<AttPosMocap>(view).x, 4.F);
    EXPECT_EQ(decode<AttPosMocap>(view).time_usec, 77U);
  });
  EXPECT_EQ(found, 1U);
}

TEST(MavlinkParser, APacketBeginsAnew) {
  Parser parser;
  const Frame first = pose(1);
  const Bytes cut(first.bytes().begin(), first.bytes().begin() + 20);
  EXPECT_TRUE(sequences(parser, cut, 100).empty());
  parser.begin_packet();
  EXPECT_EQ(sequences(parser, pose(2).bytes(), 100), std::vector<std::uint8_t>{2});
  EXPECT_EQ(parser.stats().bytes_dropped, 20U);
}

// Overlapping frames with valid checksums and any content: delivered frames must be in order, disjoint and independent
// of how the stream is cut; every typed message must decode.
TEST(MavlinkParser, RepairedNoiseIsReadTheSameInEveryPortion) {
  sim::Random random(11, "mavlink noise");
  std::size_t frames = 0;
  for (int round = 0; round < 300; ++round) {
    Bytes noise = garbage(random, 200 + static_cast<std::size_t>(random.next() % 1800));
    host_tests::repair_mavlink(noise, random.next());
    std::vector<std::uint64_t> offsets;
    for (const std::size_t portion : {std::size_t{1}, std::size_t{50}, noise.size()}) {
      Parser parser;
      std::vector<std::uint64_t> seen;
      std::uint64_t end = 0;
      for (std::size_t at = 0; at < noise.size(); at += portion) {
        parser.consume(std::span(noise).subspan(at, std::min(portion, noise.size() - at)), [&](const FrameView& frame) {
          EXPECT_GE(frame.offset, end);
          end = frame.offset + frame.bytes.size();
          EXPECT_TRUE(std::equal(frame.bytes.begin(), frame.bytes.end(),
                                 noise.begin() + static_cast<std::ptrdiff_t>(frame.offset)));
          for_each_message([&]<typename Message>() {
            if (is<Message>(frame)) {
              (void)decode<Message>(frame);
            }
          });
          EXPECT_FALSE(is_signed_with(frame, Key{}));
          seen.push_back(frame.offset);
        });
      }
      EXPECT_LE(parser.stats().bytes_dropped, parser.stats().bytes);
      EXPECT_TRUE(portion == 1 || seen == offsets) << "portions of " << portion;
      offsets = seen;
      frames += seen.size();
    }
  }
  EXPECT_GT(frames, 1000U) << "too few repaired frames for a test";
}

}  // namespace
}  // namespace m100::mavlink
