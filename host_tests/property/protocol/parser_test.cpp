// SPDX-License-Identifier: BSD-3-Clause
// Properties that must hold for any byte stream. Streams come from fixed seeds, which are printed on failure.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "host_tests/property/protocol/every_message.h"
#include "host_tests/property/protocol/reference_parser.h"
#include "host_tests/property/protocol/streams.h"
#include "protocol/crc.h"
#include "protocol/dji/frame_parser.h"

namespace m100::host_tests {
namespace {

using protocol::FrameParser;
using protocol::FrameView;

void collect(FrameParser& parser, std::span<const std::byte> bytes, std::vector<FoundFrame>& found) {
  parser.consume(bytes, [&](const FrameView& frame) {
    found.push_back({frame.offset, Bytes(frame.bytes.begin(), frame.bytes.end())});
  });
}

std::vector<FoundFrame> parse(const Bytes& stream) {
  FrameParser parser;
  std::vector<FoundFrame> found;
  collect(parser, stream, found);
  return found;
}

/// Each byte of the stream must be delivered in a frame, dropped, or pending, exactly once.
void expect_accounts_add_up(const FrameParser& parser, const std::vector<FoundFrame>& found, std::size_t bytes) {
  std::uint64_t covered = 0;
  std::uint64_t end = 0;
  for (const FoundFrame& frame : found) {
    const std::uint64_t frame_end = frame.offset + frame.bytes.size();
    covered += frame_end - std::max(end, frame.offset);
    end = std::max(end, frame_end);
  }
  EXPECT_EQ(parser.stats().bytes, bytes);
  EXPECT_EQ(parser.stats().frames, found.size());
  EXPECT_EQ(covered + parser.stats().bytes_dropped + parser.pending_bytes(), bytes);
}

// Catches mistakes in the shortcuts of the fast parser: running checksums, skipped bytes, compaction.
TEST(Parser, FindsExactlyTheFramesThatTheRulesName) {
  RecordProperty("promise", "R2");
  std::size_t frames = 0;
  for (unsigned seed = 0; seed < 3600; ++seed) {
    std::mt19937 random(seed);
    const Bytes stream = damaged_stream(40, random);
    const std::vector<FoundFrame> expected = slow_parse(stream);
    FrameParser parser;
    std::vector<FoundFrame> found;
    collect(parser, stream, found);
    ASSERT_EQ(found, expected) << "seed " << seed;
    expect_accounts_add_up(parser, found, stream.size());
    frames += found.size();
  }
  EXPECT_GT(frames, 50000U) << "too few frames for a test";
}

// The same stream in any portions must give the same frames and the same statistics.
TEST(Parser, DoesNotCareWhereTheStreamIsCut) {
  RecordProperty("promise", "R2");
  for (unsigned seed = 0; seed < 400; ++seed) {
    std::mt19937 random(seed);
    const Bytes stream = damaged_stream(25, random);
    FrameParser whole;
    std::vector<FoundFrame> expected;
    collect(whole, stream, expected);
    FrameParser pieces;
    std::vector<FoundFrame> found;
    const std::size_t longest = 1 + random() % 3000;
    for (std::size_t at = 0; at < stream.size();) {
      const std::size_t count = std::min<std::size_t>(stream.size() - at, 1 + random() % longest);
      collect(pieces, std::span(stream).subspan(at, count), found);
      at += count;
    }
    ASSERT_EQ(found, expected) << "seed " << seed;
    ASSERT_EQ(pieces.stats(), whole.stats()) << "seed " << seed;
  }
}

TEST(Parser, TakesOneByteAtATime) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    const Bytes stream = damaged_stream(25, random);
    FrameParser parser;
    std::vector<FoundFrame> found;
    for (const std::byte value : stream) {
      for (auto frame = parser.push(value); frame; frame = parser.poll()) {
        found.push_back({frame->offset, Bytes(frame->bytes.begin(), frame->bytes.end())});
      }
      ASSERT_LE(parser.pending_bytes(), protocol::kMaxFrameBytes);
    }
    ASSERT_EQ(found, slow_parse(stream)) << "seed " << seed;
  }
}

// Statistics must not depend on the portions either, even with a frame of another version at the edge of a good one.
TEST(Parser, CountsAFrameOfAnotherVersionBehindAGoodOneWhereverTheStreamIsCut) {
  const Bytes good = telemetry_frame(1);
  Bytes other = good;
  other[5] = std::byte{1};
  const std::uint16_t crc = protocol::crc16(std::span(other).first(10));
  std::memcpy(&other[10], &crc, sizeof(crc));
  Bytes stream = good;
  append(stream, other);
  append(stream, good);
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    FrameParser parser;
    std::vector<FoundFrame> found;
    collect(parser, std::span(stream).first(cut), found);
    collect(parser, std::span(stream).subspan(cut), found);
    ASSERT_EQ(found.size(), 2U) << cut;
    ASSERT_EQ(parser.stats().reserved_errors, 1U) << cut;
    ASSERT_EQ(parser.stats().crc16_errors, 0U) << cut;
  }
}

/// The expected statistics, byte by byte, for a stream without a good frame: the classes of section "Error classes" of
/// protocol/README.md.
protocol::ParserStats slow_statistics(const Bytes& stream) {
  protocol::ParserStats stats;
  for (std::size_t at = 0; at + protocol::kHeaderBytes <= stream.size(); ++at) {
    const auto byte = [&](std::size_t i) { return std::to_integer<unsigned>(stream[at + i]); };
    if (stream[at] != protocol::kStartByte) {
      continue;
    }
    const bool fixed = byte(2) < 4 && byte(3) < 64 && byte(5) + byte(6) + byte(7) == 0;
    const std::size_t length = byte(1) + 256U * (byte(2) & 3U);
    if (!fixed || protocol::crc16(std::span(stream).subspan(at, 10)) != byte(10) + 256U * byte(11)) {
      ++stats.crc16_errors;
    } else if (length < 16 && length != 12) {
      ++stats.length_errors;
    } else if (byte(4) % 32 > length - std::min<std::size_t>(length, 16) || (byte(4) >= 32 && length % 16 != 0)) {
      ++stats.padding_errors;
    } else if (at + length <= stream.size()) {
      ++stats.crc32_errors;
    } else {
      break;
    }
  }
  return stats;
}

// Catches a search that skips a header: each start byte of a stream without a frame must be counted in its class.
TEST(Parser, CountsEachStartByteOfAHostileStreamInItsClass) {
  for (unsigned seed = 0; seed < 600; ++seed) {
    std::mt19937 random(seed);
    Bytes stream(1);  // misaligned by one byte, so that no other version is detected
    while (stream.size() < 3000) {
      switch (random() % 4) {
        case 0:
          append(stream, densest_headers(8 + random() % 300, static_cast<unsigned>(random() % 40)));
          break;
        case 1: {
          Bytes piece = header(16 + random() % 900, 0, static_cast<std::uint8_t>(random() % 64), 0xAAAA);
          piece.resize(1 + random() % piece.size());
          append(stream, piece);
          break;
        }
        case 2:
          append(stream, Bytes(random() % 20, protocol::kStartByte));
          break;
        default:
          append(stream,
                 header(random() % 2 == 0 ? 0xAA : random() % 16, 0, 0xAA, static_cast<std::uint16_t>(random())));
          break;
      }
    }
    FrameParser parser;
    std::vector<FoundFrame> found;
    collect(parser, stream, found);
    if (!found.empty()) {
      continue;  // a header of 12 bytes is a frame
    }
    const protocol::ParserStats expected = slow_statistics(stream);
    ASSERT_EQ(parser.stats().crc16_errors, expected.crc16_errors) << "seed " << seed;
    ASSERT_EQ(parser.stats().length_errors, expected.length_errors) << "seed " << seed;
    ASSERT_EQ(parser.stats().padding_errors, expected.padding_errors) << "seed " << seed;
    ASSERT_EQ(parser.stats().crc32_errors, expected.crc32_errors) << "seed " << seed;
  }
}

// Exhaustive: every bit of every message is flipped once. It must never be accepted, and the next frame must arrive.
TEST(Parser, AcceptsNoMessageWithOneBitFlipped) {
  RecordProperty("promise", "R2");
  const Bytes next = telemetry_frame(7);
  for (const NamedFrame& message : every_message()) {
    for (std::size_t bit = 0; bit < 8 * message.bytes.size(); ++bit) {
      Bytes stream = message.bytes;
      stream[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
      append(stream, next);
      append(stream, Bytes(protocol::kMaxFrameBytes));  // a flipped LEN may claim this much
      const std::vector<FoundFrame> found = parse(stream);
      ASSERT_EQ(found.size(), 1U) << message.name << ", bit " << bit;
      ASSERT_EQ(found[0].bytes, next) << message.name << ", bit " << bit;
    }
  }
}

// Exhaustive: every message is cut at every length and directly followed by a good frame.
TEST(Parser, LosesNothingBehindATruncatedMessage) {
  RecordProperty("promise", "R2");
  const Bytes next = telemetry_frame(7);
  for (const NamedFrame& message : every_message()) {
    for (std::size_t size = 0; size < message.bytes.size(); ++size) {
      Bytes stream(message.bytes.begin(), message.bytes.begin() + static_cast<std::ptrdiff_t>(size));
      append(stream, next);
      append(stream, Bytes(protocol::kMaxFrameBytes));
      const std::vector<FoundFrame> found = parse(stream);
      ASSERT_EQ(found.size(), 1U) << message.name << " cut to " << size;
      ASSERT_EQ(found[0].bytes, next) << message.name << " cut to " << size;
    }
  }
}

// The parser must be in step again after at most one longest frame of clean bytes, whatever came before.
TEST(Parser, IsInStepAgainAfterOneLongestFrame) {
  RecordProperty("promise", "R2");
  for (unsigned seed = 0; seed < 500; ++seed) {
    std::mt19937 random(seed);
    Bytes stream = damaged_stream(5, random);
    append(stream, random_bytes(random() % 50, random));
    const std::size_t clean_from = stream.size();
    for (std::uint16_t number = 0; number < 20; ++number) {
      append(stream, telemetry_frame(number));
    }
    std::size_t late = 0;
    for (const FoundFrame& frame : parse(stream)) {
      late += frame.offset >= clean_from + protocol::kMaxFrameBytes ? 1U : 0U;
    }
    const std::size_t due = (20UL * 142 - protocol::kMaxFrameBytes) / 142;
    ASSERT_GE(late, due) << "seed " << seed;
  }
}

TEST(Parser, RefusesWhatNoFrameCanBeAtOnce) {
  struct Impossible {
    const char* name;
    std::size_t length;
    std::uint8_t cipher_byte;
    std::uint64_t protocol::ParserStats::*counter;
  };
  const std::uint8_t kEncrypted = 0x20;
  for (const Impossible& bad : {
           Impossible{"no length", 0, 0, &protocol::ParserStats::length_errors},
           Impossible{"shorter than a header", 11, 0, &protocol::ParserStats::length_errors},
           Impossible{"header and one byte", 13, 0, &protocol::ParserStats::length_errors},
           Impossible{"header and half a checksum", 14, 0, &protocol::ParserStats::length_errors},
           Impossible{"header and most of a checksum", 15, 0, &protocol::ParserStats::length_errors},
           Impossible{"filler without data", 12, 1, &protocol::ParserStats::padding_errors},
           Impossible{"more filler than data", 16 + 16, kEncrypted | 17, &protocol::ParserStats::padding_errors},
           Impossible{"half a cipher block", 16 + 8, kEncrypted | 2, &protocol::ParserStats::padding_errors},
           Impossible{"DJI's encrypted nothing", 28, kEncrypted | 16, &protocol::ParserStats::padding_errors},
       }) {
    Bytes stream = header(bad.length, 0, bad.cipher_byte, 1);
    const Bytes next = telemetry_frame(1);
    append(stream, next);  // must be delivered without a further byte
    FrameParser parser;
    std::vector<FoundFrame> found;
    collect(parser, stream, found);
    ASSERT_EQ(found.size(), 1U) << bad.name;
    EXPECT_EQ(parser.stats().*bad.counter, 1U) << bad.name;
    EXPECT_EQ(parser.stats().bytes_dropped, 12U) << bad.name;
    EXPECT_EQ(parser.stats().resyncs, 1U) << bad.name;
  }
}

TEST(Parser, NamesAnotherVersionOfTheProtocol) {
  Bytes stream = header(40, 0, 0, 1);
  stream[2] |= std::byte{4};  // VER 1
  const std::uint16_t crc = protocol::crc16(std::span(stream).first(10));
  stream[10] = static_cast<std::byte>(crc & 0xFFU);
  stream[11] = static_cast<std::byte>(crc >> 8U);
  FrameParser parser;
  std::vector<FoundFrame> found;
  collect(parser, stream, found);
  EXPECT_EQ(parser.stats().reserved_errors, 1U);
  EXPECT_EQ(parser.stats().crc16_errors, 0U);
}

// Each bit that must be zero is set in a frame with matching checksums.
TEST(Parser, RefusesEachReservedBitUnderGoodChecksums) {
  const Bytes good = telemetry_frame(1);
  for (const auto& [byte, first_bit] : {std::pair<std::size_t, unsigned>{2, 2}, {3, 6}, {5, 0}, {6, 0}, {7, 0}}) {
    for (unsigned bit = first_bit; bit < 8; ++bit) {
      Bytes frame = good;
      frame[byte] |= static_cast<std::byte>(1U << bit);
      const std::uint16_t header_crc = protocol::crc16(std::span(frame).first(10));
      std::memcpy(&frame[10], &header_crc, sizeof(header_crc));
      const std::uint32_t frame_crc = protocol::crc32(std::span(frame).first(frame.size() - 4));
      std::memcpy(&frame[frame.size() - 4], &frame_crc, sizeof(frame_crc));
      append(frame, good);
      FrameParser parser;
      std::vector<FoundFrame> found;
      collect(parser, frame, found);
      ASSERT_EQ(found.size(), 1U) << byte << '.' << bit;
      EXPECT_EQ(found[0].offset, good.size());
      EXPECT_EQ(parser.stats().reserved_errors, 1U) << byte << '.' << bit;
    }
  }
}

TEST(Parser, CountsEachStretchOfGarbageOnce) {
  Bytes stream;
  for (std::uint16_t number = 0; number < 5; ++number) {
    append(stream, telemetry_frame(number));
    append(stream, telemetry_frame(number));
    append(stream, Bytes(7 + number));
  }
  FrameParser parser;
  std::vector<FoundFrame> found;
  collect(parser, stream, found);
  EXPECT_EQ(parser.stats().resyncs, 5U);
  EXPECT_EQ(parser.stats().bytes_dropped, 7U + 8U + 9U + 10U + 11U);
  EXPECT_EQ(parser.stats().crc16_errors + parser.stats().crc32_errors, 0U)
      << "bytes inside good frames must not count as errors";
}

// DJI's receiver keeps the last eleven bytes of a frame, because a header may begin there.
TEST(Parser, FindsAFrameThatBeginsInTheChecksumOfAnother) {
  for (std::uint16_t sequence = 0; sequence < 2000; ++sequence) {
    const Bytes first = make_frame({.is_ack = true, .sequence = sequence}, nullptr, Bytes(2));
    if (first.back() != protocol::kStartByte) {
      continue;
    }
    Bytes stream = first;
    const Bytes second = telemetry_frame(sequence);
    append(stream, std::span(second).subspan(1));
    const std::vector<FoundFrame> found = parse(stream);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_EQ(found[1].bytes, second);
    return;
  }
  FAIL() << "found no checksum that ends in the start byte";
}

// If a link falls silent inside a frame, the next frame must not have to wait until the claimed length is complete.
TEST(Parser, AbandonsACandidateOnDemand) {
  FrameParser parser;
  std::vector<FoundFrame> found;
  collect(parser, header(1000, 0, 0, 1), found);
  const Bytes next = telemetry_frame(3);
  collect(parser, next, found);
  EXPECT_TRUE(found.empty());
  parser.abandon_candidate();
  collect(parser, Bytes(1), found);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].bytes, next);
}

TEST(Parser, KeepsGoodFramesAmongGarbageWithoutStartBytes) {
  setenv("RC_PARAMS", "seed=7 max_success=200", 0);
  const bool holds = rc::check("all frames between stretches without a start byte arrive", [] {
    const auto gaps = *rc::gen::container<std::vector<std::vector<std::uint8_t>>>(
        rc::gen::container<std::vector<std::uint8_t>>(rc::gen::distinctFrom(std::uint8_t{0xAA})));
    Bytes stream;
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      append(stream, std::as_bytes(std::span(gaps[i])));
      append(stream, telemetry_frame(static_cast<std::uint16_t>(i)));
    }
    RC_ASSERT(parse(stream).size() == gaps.size());
  });
  EXPECT_TRUE(holds);
}

}  // namespace
}  // namespace m100::host_tests
