// SPDX-License-Identifier: BSD-3-Clause
#include "protocol/mavlink/signature.h"

#include <gtest/gtest.h>

#include "protocol/mavlink/messages.h"
#include "protocol/mavlink/parser.h"

namespace m100::mavlink {
namespace {

constexpr Key kKey{std::byte{1}, std::byte{2}, std::byte{3}};

Frame signed_pose(SignatureTime time, const Key& key = kKey) {
  Frame frame =
      encode(AttPosMocap{.time_usec = 7, .q = {1.F, 0.F, 0.F, 0.F}, .x = 1.F, .y = 2.F, .z = -3.F}, {9, 1}, 4);
  sign(frame, key, 2, time);
  return frame;
}

/// Parses one frame. @returns a view of the bytes, or a status if no frame was found.
core::Expected<FrameView> parse(Parser& parser, std::span<const std::byte> bytes) {
  EXPECT_EQ(parser.push(bytes), bytes.size());
  return parser.poll();
}

TEST(Signature, HoldsForItsKeyOnly) {
  const Frame frame = signed_pose(1000);
  Parser parser;
  const auto view = parse(parser, frame.bytes());
  ASSERT_TRUE(view);
  EXPECT_TRUE(view->is_signed);
  EXPECT_TRUE(is_signed_with(*view, kKey));
  Key other = kKey;
  other[31] = std::byte{1};
  EXPECT_FALSE(is_signed_with(*view, other));
  EXPECT_EQ(signature_of(*view).time, 1000U);
  EXPECT_EQ(signature_of(*view).link, 2);
}

// Would catch a signature that does not cover a byte: of the header, the link id or the time stamp.
TEST(Signature, NoFlippedBitPasses) {
  const Frame good = signed_pose(1000);
  for (std::size_t bit = 0; bit < 8 * good.size; ++bit) {
    Frame bad = good;
    bad.space[bit / 8] ^= std::byte{1} << (bit % 8);
    Parser parser;
    const auto view = parse(parser, bad.bytes());
    EXPECT_FALSE(view && is_signed_with(*view, kKey)) << "bit " << bit;
  }
}

TEST(Signature, AFrameWithoutOnePassesNoKey) {
  Parser parser;
  const Frame frame = encode(Heartbeat{.custom_mode = 1}, {1, 1}, 0);
  const auto view = parse(parser, frame.bytes());
  ASSERT_TRUE(view);
  EXPECT_FALSE(view->is_signed);
  EXPECT_FALSE(is_signed_with(*view, kKey));
}

TEST(ReplayGuard, EachStreamOnlyMovesOn) {
  ReplayGuard guard;
  constexpr SignatureTime kNow = 1000 * kSignatureTicksPerSecond;
  EXPECT_EQ(guard.accept({1, 1}, {.link = 0, .time = kNow}, kNow), core::Status::kOk);
  EXPECT_EQ(guard.accept({1, 1}, {.link = 0, .time = kNow}, kNow), core::Status::kRefused) << "doubled";
  EXPECT_EQ(guard.accept({1, 1}, {.link = 0, .time = kNow - 1}, kNow), core::Status::kRefused) << "overtaken";
  EXPECT_EQ(guard.accept({1, 1}, {.link = 1, .time = kNow - 1}, kNow), core::Status::kOk) << "another link";
  EXPECT_EQ(guard.accept({1, 2}, {.link = 0, .time = kNow - 1}, kNow), core::Status::kOk) << "another component";
  EXPECT_EQ(guard.accept({2, 1}, {.link = 0, .time = kNow - 1}, kNow), core::Status::kOk) << "another system";
  EXPECT_EQ(guard.accept({1, 1}, {.link = 0, .time = kNow + 1}, kNow), core::Status::kOk);
  EXPECT_EQ(guard.newest(), kNow + 1);
}

// Would catch a guard that accepts a recording of an earlier flight that is played back under a new name.
TEST(ReplayGuard, AnOldRecordingBeginsNoStream) {
  ReplayGuard guard;
  constexpr SignatureTime kNow = 1000 * kSignatureTicksPerSecond;
  constexpr SignatureTime kMinute = 60 * kSignatureTicksPerSecond;
  EXPECT_EQ(guard.accept({1, 1}, {.link = 0, .time = kNow - kMinute - 1}, kNow), core::Status::kTimeout);
  EXPECT_EQ(guard.accept({1, 1}, {.link = 0, .time = kNow - kMinute}, kNow), core::Status::kOk);
}

TEST(ReplayGuard, TheNumberOfStreamsIsBounded) {
  ReplayGuard guard;
  for (std::uint8_t system = 0; system < ReplayGuard::kStreams; ++system) {
    EXPECT_EQ(guard.accept({system, 1}, {.link = 0, .time = 5}, 5), core::Status::kOk);
  }
  EXPECT_EQ(guard.accept({99, 1}, {.link = 0, .time = 6}, 5), core::Status::kResourceExhausted);
  EXPECT_EQ(guard.accept({3, 1}, {.link = 0, .time = 6}, 5), core::Status::kOk) << "a known one goes on";
}

// A forgotten stream must not be accepted again with old frames: a stream may be forgotten only when its frames are too
// old anyway.
TEST(ReplayGuard, AStreamThatFellSilentMakesRoomAndItsRecordingStaysRefused) {
  constexpr SignatureTime kMinute = ReplayGuard::kLatestStart;
  ReplayGuard guard;
  for (std::uint8_t system = 0; system < ReplayGuard::kStreams; ++system) {
    EXPECT_EQ(guard.accept({system, 1}, {.link = 0, .time = 5}, 5), core::Status::kOk);
  }
  EXPECT_EQ(guard.accept({99, 1}, {.link = 0, .time = 5 + kMinute}, 5), core::Status::kResourceExhausted);
  EXPECT_EQ(guard.accept({99, 1}, {.link = 0, .time = 6 + kMinute}, 6 + kMinute), core::Status::kOk);
  EXPECT_EQ(guard.accept({0, 1}, {.link = 0, .time = 5}, 5), core::Status::kTimeout)
      << "the forgotten one, played back";
  EXPECT_EQ(guard.accept({1, 1}, {.link = 0, .time = 5}, 5), core::Status::kRefused) << "one that is still known";
}

// Would catch a guard that loses its memory with the program: the last minute of a flight could be played back to the
// next one.
TEST(ReplayGuard, RemembersWhatAnEarlierLifeAccepted) {
  constexpr SignatureTime kNow = 1000 * kSignatureTicksPerSecond;
  ReplayGuard before;
  EXPECT_EQ(before.accept({1, 1}, {.link = 0, .time = kNow}, 0), core::Status::kOk);
  ReplayGuard after(before.memory());
  EXPECT_EQ(after.accept({1, 1}, {.link = 0, .time = kNow}, 0), core::Status::kRefused);
  EXPECT_EQ(after.accept({2, 1}, {.link = 0, .time = kNow - ReplayGuard::kLatestStart - 1}, 0), core::Status::kTimeout);
  EXPECT_EQ(after.accept({1, 1}, {.link = 0, .time = kNow + 1}, 0), core::Status::kOk);
  ReplayGuard later(after.memory());
  EXPECT_EQ(later.accept({1, 1}, {.link = 0, .time = kNow + 2}, kNow + 2 * ReplayGuard::kLatestStart),
            core::Status::kTimeout)
      << "held back for longer than a minute, and then delivered to the next flight";
}

// If our own clock was wrong once, that must not exclude every sender for ever.
TEST(ReplayGuard, OurOwnClockIsNotRemembered) {
  ReplayGuard guard;
  EXPECT_EQ(guard.accept({1, 1}, {.link = 0, .time = 50}, 40), core::Status::kOk);
  (void)guard.accept({1, 1}, {.link = 0, .time = 51}, 1U << 30U);
  EXPECT_EQ(guard.newest(), 1U << 30U);
  EXPECT_EQ(guard.memory().newest, 51U);
}

// A signer that was seeded once counts on from there: libmavlink and pymavlink do. Its frames must rise, and those that
// were sent before stay refused.
TEST(ReplayGuard, ASignerBehindTheClockBeginsOnTheOperatorsWord) {
  constexpr SignatureTime kNow = 1000 * kSignatureTicksPerSecond;
  constexpr SignatureTime kSeed = kNow - 180 * kSignatureTicksPerSecond;
  const Address from{.system = 1, .component = 197};
  ReplayGuard strict;
  EXPECT_EQ(strict.accept(from, {.link = 1, .time = kSeed}, kNow), core::Status::kTimeout);
  ReplayGuard guard;
  guard.accept_any_clock(true);
  EXPECT_EQ(guard.accept(from, {.link = 1, .time = kSeed}, kNow), core::Status::kOk);
  EXPECT_EQ(guard.accept(from, {.link = 1, .time = kSeed + 1}, kNow), core::Status::kOk);
  EXPECT_EQ(guard.accept(from, {.link = 1, .time = kSeed + 1}, kNow), core::Status::kRefused);
  ReplayGuard next(guard.memory());
  next.accept_any_clock(true);
  EXPECT_EQ(next.accept(from, {.link = 1, .time = kSeed}, kNow), core::Status::kRefused) << "sent before";
  EXPECT_EQ(next.accept(from, {.link = 1, .time = kSeed + 2}, kNow), core::Status::kOk);
}

}  // namespace
}  // namespace m100::mavlink
