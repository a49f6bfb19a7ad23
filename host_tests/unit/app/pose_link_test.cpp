// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/pose_link.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "host_tests/sim/random.h"

namespace m100::app {
namespace {

using protocol::PoseMessage;
using std::chrono::milliseconds;

PoseMessage pose(std::uint32_t sequence) {
  return {
      .sequence = sequence, .age_us = 4000, .position_w_m = {1.F, -2.F, 0.5F}, .rotation_wb = {0.8F, 0.F, 0.F, 0.6F}};
}

// Made by Python: struct.pack('<2sBBII3f4f', b'PM', 1, 0, 7, 4000, 1, -2, 0.5, 0.8, 0, 0, 0.6) and the link's CRC32
// (reflected 0xEDB88320, start 0x3AA3, no final XOR) over it.
TEST(PoseMessageTest, TheBytesAreThoseOfAnIndependentEncoder) {
  const std::vector<unsigned> expected = {0x50, 0x4D, 0x01, 0x00, 0x07, 0x00, 0x00, 0x00, 0xA0, 0x0F, 0x00,
                                          0x00, 0x00, 0x00, 0x80, 0x3F, 0x00, 0x00, 0x00, 0xC0, 0x00, 0x00,
                                          0x00, 0x3F, 0xCD, 0xCC, 0x4C, 0x3F, 0x00, 0x00, 0x00, 0x00, 0x00,
                                          0x00, 0x00, 0x00, 0x9A, 0x99, 0x19, 0x3F, 0x14, 0xC3, 0xB9, 0x28};
  const protocol::PoseBytes bytes = protocol::encode(pose(7));
  ASSERT_EQ(bytes.size(), expected.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    EXPECT_EQ(std::to_integer<unsigned>(bytes[i]), expected[i]) << "byte " << i;
  }
}

TEST(PoseMessageTest, NoFlippedBitIsAccepted) {
  const protocol::PoseBytes good = protocol::encode(pose(7));
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    protocol::PoseBytes bad = good;
    bad[bit / 8] ^= std::byte{1} << (bit % 8);
    protocol::PoseParser parser;
    for (const std::byte value : bad) {
      EXPECT_FALSE(parser.push(value).has_value()) << "bit " << bit;
    }
    std::size_t found = 0;
    for (int copies = 0; copies < 2; ++copies) {  // the damaged one may swallow at most its own length
      for (const std::byte value : good) {
        found += parser.push(value).has_value() ? 1U : 0U;
      }
    }
    EXPECT_GE(found, 1U) << "bit " << bit;
  }
}

TEST(PoseMessageTest, TruncatedAnywhereTheNextMessageIsNotLost) {
  const protocol::PoseBytes good = protocol::encode(pose(7));
  for (std::size_t length = 0; length < good.size(); ++length) {
    protocol::PoseParser parser;
    for (std::size_t i = 0; i < length; ++i) {
      (void)parser.push(good[i]);
    }
    std::size_t found = 0;
    for (const std::byte value : good) {
      found += parser.push(value).has_value() ? 1U : 0U;
    }
    for (const std::byte value : good) {
      found += parser.push(value).has_value() ? 1U : 0U;
    }
    EXPECT_EQ(found, 2U) << length;
  }
}

TEST(PoseMessageTest, EveryMessageAmongGarbageIsFound) {
  sim::Random random(3, "pose");
  protocol::PoseParser parser;
  std::size_t found = 0;
  for (std::uint32_t n = 0; n < 1000; ++n) {
    const std::uint64_t garbage = random.next() % 60;
    for (std::size_t i = 0; i < garbage; ++i) {
      const bool tempting = random.next() % 4 == 0;
      (void)parser.push(tempting ? std::byte{'P'} : static_cast<std::byte>(random.next() >> 56U));
    }
    for (const std::byte value : protocol::encode(pose(n))) {
      const core::Expected<PoseMessage> message = parser.push(value);
      found += message && message->sequence == n ? 1U : 0U;
    }
  }
  EXPECT_EQ(found, 1000U);
}

TEST(PoseMessageTest, NumbersThatCannotBeAreRefusedAtTheBorder) {
  RecordProperty("promise", "R11");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<PoseMessage> bad(6, pose(1));
  bad[0].position_w_m[0] = nan;
  bad[1].position_w_m[2] = 2000.F;
  bad[2].rotation_wb = {0.F, 0.F, 0.F, 0.F};
  bad[3].rotation_wb[1] = nan;
  bad[4].position_w_m[1] = std::numeric_limits<float>::infinity();
  bad[5].age_us = 20000000;
  for (const PoseMessage& message : bad) {
    protocol::PoseParser parser;
    core::Expected<PoseMessage> last = core::Status::kNotReady;
    for (const std::byte value : protocol::encode(message)) {
      last = parser.push(value);
    }
    EXPECT_EQ(last.status(), core::Status::kOutOfRange);
    EXPECT_EQ(parser.stats().refused, 1U);
  }
}

struct PoseLinkTest : ::testing::Test {
  hal::ManualClock clock;
  hal::UartPair cable{clock, 115200};
  PoseLink link{cable.a(), 115200};
  void send(std::uint32_t sequence) {
    (void)cable.b().write(protocol::encode(pose(sequence)));
    clock.advance(milliseconds(10));
  }
};

TEST_F(PoseLinkTest, TheNewestOfATickCountsAndItsAgeIncludesTheLine) {
  send(1);
  send(2);
  const core::Expected<PoseSample> sample = link.receive(clock.now());
  ASSERT_TRUE(sample.has_value());
  EXPECT_EQ(sample->message.sequence, 2U);
  EXPECT_EQ(sample->age.count(), 4000 + 3819);  // 44 bytes of 10 bits at 115200
  EXPECT_EQ(link.receive(clock.now()).status(), core::Status::kNotReady);
}

TEST_F(PoseLinkTest, DoubledAndOldMessagesAreRefusedButARestartedSenderIsHeard) {
  for (const std::uint32_t sequence : {5000U, 5000U, 4999U, 5003U}) {
    send(sequence);
    (void)link.receive(clock.now());
  }
  EXPECT_EQ(link.refused_sequences(), 2U);
  EXPECT_EQ(link.lost_messages(), 2U);
  send(1);
  EXPECT_TRUE(link.receive(clock.now()).has_value());
  send(0xFFFFFFFF);
  EXPECT_FALSE(link.receive(clock.now()).has_value());
  clock.advance(milliseconds(1100));
  send(0xFFFFFFFF);
  EXPECT_TRUE(link.receive(clock.now()).has_value());
  send(0);
  EXPECT_TRUE(link.receive(clock.now()).has_value()) << "the number wraps";
}

}  // namespace
}  // namespace m100::app
