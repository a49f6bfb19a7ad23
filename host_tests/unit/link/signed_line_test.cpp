// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/pose/signed_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <vector>

#include "firmware/link/pose/pose_link.h"
#include "protocol/mavlink/messages.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::link {
namespace {

using mavlink::SignatureTime;
using Packet = std::vector<std::byte>;

constexpr mavlink::Key kKey{std::byte{1}, std::byte{2}, std::byte{3}};
constexpr mavlink::Key kOtherKey{std::byte{1}, std::byte{2}, std::byte{4}};
constexpr mavlink::Address kSender{.system = 9, .component = 197};
constexpr SignatureTime kNow = 1000 * mavlink::kSignatureTicksPerSecond;

/// A network in memory.
class Packets final : public hal::PacketUart {
 public:
  core::Expected<std::size_t> read(std::span<std::byte> destination) override {
    ++reads;
    if (at_ == waiting.size()) {
      return std::size_t{0};
    }
    const Packet& packet = waiting[at_];
    begins_ = done_ == 0;
    const std::size_t count = std::min(destination.size(), packet.size() - done_);
    std::copy_n(packet.begin() + static_cast<std::ptrdiff_t>(done_), count, destination.begin());
    done_ += count;
    if (done_ == packet.size()) {
      ++at_;
      done_ = 0;
    }
    return count;
  }
  core::Expected<std::size_t> write(std::span<const std::byte> source) override {
    written.emplace_back(source.begin(), source.end());
    return source.size();
  }
  bool begins_packet() const override { return begins_; }
  void answer_last() override { answered.push_back(done_ == 0 ? at_ - 1 : at_); }

  std::deque<Packet> waiting;
  std::vector<Packet> written;
  std::vector<std::size_t> answered;  ///< numbers of the packets whose senders were believed
  std::size_t reads = 0;

 private:
  std::size_t at_ = 0;
  std::size_t done_ = 0;
  bool begins_ = false;
};

struct SignedLineTest : ::testing::Test {
  Packets network;
  SignedLine line{network, kKey, mavlink::ReplayMemory{}, 1};
  PoseLink poses{line, 0};
  core::TimePoint now{std::chrono::seconds(1)};
  std::uint8_t frames = 0;

  static Packet bytes_of(const mavlink::Frame& frame) { return {frame.bytes().begin(), frame.bytes().end()}; }
  mavlink::Frame pose(std::uint64_t stamp_us) {
    return mavlink::encode(mavlink::AttPosMocap{.time_usec = stamp_us, .q = {1.F, 0.F, 0.F, 0.F}, .x = 1.F}, kSender,
                           frames++);
  }
  Packet signed_pose(std::uint64_t stamp_us, SignatureTime time, const mavlink::Key& key = kKey) {
    mavlink::Frame frame = pose(stamp_us);
    mavlink::sign(frame, key, 2, time);
    return bytes_of(frame);
  }
  void send(Packet packet) { network.waiting.push_back(std::move(packet)); }
  core::Expected<core::Pose<double>> tick(core::Duration time = core::kTickPeriod) {
    now += time;
    line.tick(now, kNow);
    return poses.receive(now);
  }
};

TEST_F(SignedLineTest, HandsOnWhatIsSignedAndNewAndCountsTheRest) {
  send(signed_pose(1000, kNow));
  ASSERT_TRUE(tick());
  send(bytes_of(pose(2000)));
  EXPECT_FALSE(tick()) << "unsigned";
  send(signed_pose(3000, kNow + 1, kOtherKey));
  EXPECT_FALSE(tick()) << "signed with another key";
  Packet changed = signed_pose(4000, kNow + 2);
  ASSERT_FALSE(changed.empty());
  changed[changed.size() - 1] ^= std::byte{1};
  send(changed);
  EXPECT_FALSE(tick()) << "changed on its way";
  send(signed_pose(5000, kNow));
  EXPECT_FALSE(tick()) << "not newer than what this sender signed last";
  mavlink::Frame foreign = mavlink::encode(mavlink::AttPosMocap{.time_usec = 1}, {.system = 77, .component = 1}, 0);
  mavlink::sign(foreign, kKey, 2, kNow - mavlink::ReplayGuard::kLatestStart - 1);
  send(bytes_of(foreign));
  EXPECT_FALSE(tick()) << "the first of its sender, and more than a minute old";
  send(signed_pose(6000, kNow + 3));
  EXPECT_TRUE(tick());
  const SignedLineStats& stats = line.stats();
  EXPECT_EQ(stats.accepted, 2U);
  EXPECT_EQ(stats.unsigned_frames, 1U);
  EXPECT_EQ(stats.wrong, 2U);
  EXPECT_EQ(stats.replayed, 1U);
  EXPECT_EQ(stats.old, 1U);
  EXPECT_EQ(stats.old_by, mavlink::ReplayGuard::kLatestStart + 1);
  EXPECT_EQ(stats.refused(), 5U);
  EXPECT_EQ(network.answered, (std::vector<std::size_t>{0, 6})) << "only who was believed is answered";
}

// Catches a seventeenth sender that replaces a known one: the memory that refuses its old frames would be lost.
TEST_F(SignedLineTest, RemembersSixteenSendersAndTakesNoOther) {
  const auto signed_by = [this](std::uint8_t system) {
    mavlink::Frame frame = mavlink::encode(mavlink::AttPosMocap{.time_usec = 1}, {.system = system, .component = 1}, 0);
    mavlink::sign(frame, kKey, 2, kNow + system);
    send(bytes_of(frame));
    (void)tick();
  };
  for (std::uint8_t system = 1; system <= mavlink::ReplayGuard::kStreams; ++system) {
    signed_by(system);
  }
  EXPECT_EQ(line.stats().accepted, mavlink::ReplayGuard::kStreams);
  signed_by(100);
  EXPECT_EQ(line.stats().too_many, 1U);
  EXPECT_EQ(network.answered.size(), mavlink::ReplayGuard::kStreams);
  signed_by(1);
  EXPECT_EQ(line.stats().replayed, 1U) << "the first is still known";
}

// Would catch a line that accepts a frame of MAVLink 1, which cannot be signed.
TEST_F(SignedLineTest, RefusesTheOlderProtocol) {
  const Packet heartbeat_1{std::byte{0xFE}, std::byte{9}, std::byte{0}, std::byte{1}, std::byte{1}, std::byte{0}};
  Packet frame = heartbeat_1;
  frame.resize(6 + 9);
  const std::byte extra{50};
  const std::uint16_t crc =
      mavlink::checksum(std::span(&extra, 1), mavlink::checksum(std::span<const std::byte>(frame).subspan(1)));
  frame.push_back(static_cast<std::byte>(crc & 0xFFU));
  frame.push_back(static_cast<std::byte>(crc >> 8U));
  send(frame);
  (void)tick();
  EXPECT_EQ(line.stats().unsigned_frames, 1U);
}

// Would catch a line that joins packets: a stranger's half frame would swallow the following pose.
TEST_F(SignedLineTest, HalfAFrameOfAStrangerSpoilsNothing) {
  Packet beginning = bytes_of(mavlink::encode(mavlink::Odometry{.time_usec = 1, .child_frame_id = 12}, kSender, 0));
  ASSERT_GT(beginning.size(), 200U) << "a header that waits for more than the pose has";
  beginning.resize(20);
  send(beginning);
  send(signed_pose(1000, kNow + 1));
  EXPECT_TRUE(tick());
}

TEST_F(SignedLineTest, AFloodInOnePacketIsVerifiedForFortyEightFrames) {
  Packet packet;
  for (int i = 0; i < 100; ++i) {
    const Packet frame = signed_pose(1, kNow, kOtherKey);
    packet.insert(packet.end(), frame.begin(), frame.end());
  }
  send(packet);
  line.tick(now, kNow);
  (void)poses.receive(now);
  EXPECT_EQ(line.stats().wrong, 48U);
}

TEST_F(SignedLineTest, SeveralFramesInAPacketCount) {
  Packet packet = signed_pose(1000, kNow);
  const Packet second = signed_pose(2000, kNow + 1);
  packet.insert(packet.end(), second.begin(), second.end());
  send(packet);
  const core::Expected<core::Pose<double>> newest = tick();
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->captured.time_since_epoch().count(), 2000);
  EXPECT_EQ(line.stats().accepted, 2U);
}

// Would catch a line that verifies frames as long as any come: a flood would stop the flight.
TEST_F(SignedLineTest, AFloodCostsABoundedShareOfATickAndIsWorkedOffLater) {
  for (int i = 0; i < 500; ++i) {
    send(signed_pose(1, kNow, kOtherKey));
  }
  line.tick(now += core::kTickPeriod, kNow);
  for (int call = 0; call < 100; ++call) {
    (void)poses.receive(now);
  }
  EXPECT_LE(line.stats().wrong, SignedLine::kVerificationsPerTick);
  EXPECT_EQ(network.reads, 16U) << "a packet each";
  const std::uint32_t in_a_tick = line.stats().wrong;
  EXPECT_GT(in_a_tick, 10U);
  // A late tick empties the queue, because its reader drops old poses.
  line.tick(now += std::chrono::milliseconds(300), kNow);
  for (int call = 0; call < 100; ++call) {
    (void)poses.receive(now);
  }
  EXPECT_GE(line.stats().wrong, 5 * in_a_tick);
  EXPECT_LE(line.stats().wrong, (1 + SignedLine::kLateFactor) * SignedLine::kVerificationsPerTick);
  EXPECT_EQ(line.stats().interrupted, 1U) << "the first tick had no other before it";
}

// Catches a line that takes every later tick for a late one, and one that gives a late tick no more than any other.
TEST_F(SignedLineTest, EachTickHasItsOwnBudgetAndOnlyALateOneHasMore) {
  const auto verified_in = [this](core::Duration after) {
    for (std::uint32_t i = 0; i < 2 * SignedLine::kLateFactor * SignedLine::kVerificationsPerTick; ++i) {
      send(signed_pose(1, kNow, kOtherKey));
    }
    const std::uint32_t before = line.stats().wrong;
    line.tick(now += after, kNow);
    for (int call = 0; call < 100; ++call) {
      (void)poses.receive(now);
    }
    return line.stats().wrong - before;
  };
  const std::uint32_t first = verified_in(core::kTickPeriod);
  for (int tick = 0; tick < 5; ++tick) {
    EXPECT_LE(verified_in(core::kTickPeriod), SignedLine::kVerificationsPerTick) << tick;
  }
  EXPECT_LE(verified_in(2 * core::kTickPeriod), SignedLine::kVerificationsPerTick) << "not late yet";
  EXPECT_EQ(verified_in(2 * core::kTickPeriod + core::Duration{1}), 8 * first);
  EXPECT_LE(verified_in(core::kTickPeriod), SignedLine::kVerificationsPerTick);
}

TEST_F(SignedLineTest, SignsWhatLeavesWithRisingTimesNotBehindWhatItHeard) {
  send(signed_pose(1000, kNow + 500));  // the sender's clock is ahead of ours
  ASSERT_TRUE(tick());
  poses.request_time(now);
  now += std::chrono::seconds(1);
  poses.request_time(now);
  ASSERT_EQ(network.written.size(), 2U);
  SignatureTime last = kNow + 499;
  for (const Packet& packet : network.written) {
    mavlink::Parser parser;
    int found = 0;
    parser.consume(packet, [&](const mavlink::FrameView& frame) {
      ++found;
      EXPECT_TRUE(mavlink::is<mavlink::Timesync>(frame));
      EXPECT_TRUE(is_signed_with(frame, kKey));
      EXPECT_GT(signature_of(frame).time, last);
      EXPECT_EQ(signature_of(frame).link, 1);
      last = signature_of(frame).time;
    });
    EXPECT_EQ(found, 1);
  }
  EXPECT_EQ(line.write(std::array{std::byte{1}, std::byte{2}}).status(), core::Status::kInvalidArgument);
  const std::vector<std::byte> longest(mavlink::Frame{}.space.size(), mavlink::kStart2);
  EXPECT_EQ(line.write(longest).status(), core::Status::kInvalidArgument) << "no room for the signature";
  const mavlink::Frame plain = pose(1);
  EXPECT_EQ(line.write(plain.bytes()).value(), plain.size) << "as if nothing had been added";
  SignedLine quiet(network, kKey, mavlink::ReplayMemory{}, 1);
  EXPECT_EQ(quiet.min_time(), 0U);
  quiet.tick(now, kNow);
  EXPECT_EQ(quiet.min_time(), kNow) << "it has heard nothing";
}

TEST_F(SignedLineTest, AnEarlierLifeIsRemembered) {
  const Packet recorded = signed_pose(1000, kNow);
  send(recorded);
  ASSERT_TRUE(tick());
  Packets again;
  again.waiting.push_back(recorded);
  again.waiting.push_back(signed_pose(2000, kNow + 1));
  SignedLine reborn(static_cast<hal::Uart&>(again), kKey, line.memory(), 1);
  reborn.tick(now, kNow);
  std::array<std::byte, 64> bytes{};
  EXPECT_GT(reborn.read(bytes).value_or(0), 0U);
  EXPECT_EQ(reborn.stats().replayed, 1U);
  EXPECT_TRUE(again.answered.empty()) << "a line without packets answers no sender";
}

}  // namespace
}  // namespace m100::link
