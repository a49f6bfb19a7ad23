// SPDX-License-Identifier: BSD-3-Clause
// Frames with valid checksums and invalid content: each is counted by its kind, and control continues.
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "firmware/link/serial_link.h"
#include "host_tests/sim/ports/link_bench.h"
#include "protocol/dji/catalogue.h"
#include "protocol/dji/frame_encoder.h"

namespace m100::link::malformed {
namespace {

using safety::AuthorityStage;
using Bytes = std::vector<std::byte>;

/// Encrypts nothing; it only stands for another key.
class PlainCipher final : public protocol::Cipher {
 public:
  void encrypt(std::span<std::byte, protocol::kCipherBlockBytes>) const override {}
  void decrypt(std::span<std::byte, protocol::kCipherBlockBytes>) const override {}
};

class Malformed : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(bench_.take_control());
    before_ = bench_.link.health();
  }
  /// Sends it in the autopilot's place and waits until it has arrived.
  void say(const protocol::Envelope& envelope, const protocol::MessageId* id, const Bytes& value,
           const protocol::Cipher* cipher = nullptr) {
    std::array<std::byte, protocol::kMaxFrameBytes> space;
    const auto frame = protocol::encode_frame(envelope, id, value, space, cipher);
    ASSERT_TRUE(frame);
    ASSERT_EQ(bench_.cable().b().write(*frame).value_or(0), frame->size());
    bench_.run(std::chrono::milliseconds(50));
  }
  std::uint32_t bad() const { return bench_.link.health().bad_packages - before_.bad_packages; }
  bool in_control() const { return bench_.link.authority().stage == AuthorityStage::kInControl; }

  sim::LinkBench bench_{{}};
  LinkHealth before_;
};

TEST_F(Malformed, WhatNoKeyOpensIsCountedAsSuch) {
  const PlainCipher cipher;
  const protocol::MessageId id = protocol::ids::kTelemetry;
  say({.encrypted = true}, &id, Bytes(20), &cipher);
  EXPECT_EQ(bench_.link.health().undecipherable, 1U);
  EXPECT_EQ(bad(), 0U);
  EXPECT_TRUE(in_control());
}

// Catches a package that is read beyond its end, and one of which a part is used.
TEST_F(Malformed, TelemetryThatIsShorterThanItsItemsIsBad) {
  const protocol::MessageId id = protocol::ids::kTelemetry;
  say({}, &id, Bytes{std::byte{0xFF}, std::byte{0xFF}, std::byte{1}});
  EXPECT_EQ(bad(), 1U);
  EXPECT_TRUE(in_control());
}

// Catches a frame of any size that ends control because of its id, and an unknown push that ends anything.
TEST_F(Malformed, PushesOfAnotherSizeOrNameAreBadAndEndNothing) {
  const protocol::MessageId lost = protocol::ids::kControlLost;
  say({}, &lost, Bytes{std::byte{4}, std::byte{4}});
  EXPECT_EQ(bad(), 1U);
  const protocol::MessageId unknown{.set = 0x02, .id = 0x7F};
  say({}, &unknown, Bytes{std::byte{4}});
  EXPECT_EQ(bad(), 2U);
  say({}, nullptr, {});
  EXPECT_EQ(bad(), 2U) << "an empty frame says nothing at all";
  EXPECT_TRUE(in_control());
}

// Our own frames come back on a half-duplex line: they are no sign of life of an autopilot.
TEST_F(Malformed, OurOwnQuestionsAreCountedAsEchoes) {
  bench_.autopilot.happen(sim::N1EventKind::kSilence, 5);
  bench_.autopilot.happen(sim::N1EventKind::kLoseAcks, 1000);
  const protocol::MessageId ids[] = {protocol::ids::kVersionQuery, protocol::ids::kActivation,
                                     protocol::ids::kControlRequest};
  for (std::uint32_t echoes = 0; echoes < 12; ++echoes) {
    EXPECT_EQ(bench_.link.health().echoes, echoes);
    say({}, &ids[echoes % 3], Bytes{std::byte{0}});
  }
  EXPECT_EQ(bad(), 0U);
  EXPECT_FALSE(bench_.link.authority().link_alive);
}

// Catches a repeated push that is answered with a new answer or not at all: the autopilot repeats it until it has
// received an answer.
TEST_F(Malformed, AReliablePushIsAnsweredEachTimeItComesAndObeyedOnce) {
  bench_.commanding = false;
  bench_.run(std::chrono::milliseconds(200));
  const protocol::MessageId lost = protocol::ids::kControlLost;
  const protocol::Envelope reliable{.session = protocol::kFirstReliableSession, .sequence = 77};
  const std::uint64_t sent = bench_.link.health().bytes_sent;
  say(reliable, &lost, Bytes{std::byte{4}});
  EXPECT_FALSE(in_control());
  const std::uint64_t answer = bench_.link.health().bytes_sent - sent;
  EXPECT_EQ(answer, protocol::frame_bytes(2, false)) << "an acknowledgement with its code";
  say(reliable, &lost, Bytes{std::byte{4}});
  EXPECT_EQ(bench_.link.health().bytes_sent - sent, 2 * answer);
  EXPECT_EQ(bad(), 0U);
}

}  // namespace
}  // namespace m100::link::malformed
