// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/pose/pose_link.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "protocol/mavlink/pose_messages.h"
#include "protocol/mavlink/state_messages.h"

namespace m100::link {
namespace {

using mavlink::AttPosMocap;
using mavlink::Timesync;
using std::chrono::milliseconds;
constexpr mavlink::Address kSender{.system = 9, .component = 197};
constexpr std::uint64_t kUnix_us = 1763757191000000;  // the sender's clock when ours shows zero

AttPosMocap mocap(std::uint64_t stamp_us) {
  return {.time_usec = stamp_us, .q = {0.8F, 0.F, 0.F, 0.6F}, .x = 1.F, .y = -2.F, .z = 0.5F};
}

struct PoseLinkTest : ::testing::Test {
  hal::ManualClock clock;
  hal::UartPair cable{clock, 115200};
  PoseLink link{cable.a(), 115200};
  std::uint8_t frames = 0;

  template <typename Message>
  void write(const Message& message, mavlink::Address from = kSender) {
    (void)cable.b().write(mavlink::encode(message, from, frames++).bytes());
  }
  core::Expected<core::Pose<double>> after(core::Duration time) {
    clock.advance(time);
    return link.receive(clock.now());
  }
  core::Expected<core::Pose<double>> send(std::uint64_t stamp_us) {
    write(mocap(stamp_us));
    return after(milliseconds(10));
  }
};

TEST_F(PoseLinkTest, TheNewestOfATickCountsAndKeepsItsStamp) {
  write(mocap(1000));
  write(mocap(2000));
  write(mavlink::Timesync{.tc1 = 1, .ts1 = 1});  // 21 bytes follow, without the trailing zeros
  const core::Expected<core::Pose<double>> pose = after(milliseconds(20));
  ASSERT_TRUE(pose.has_value());
  EXPECT_EQ(pose->captured.time_since_epoch().count(), 2000);
  EXPECT_EQ(pose->sequence, 2U);
  EXPECT_EQ(link.stats().poses, 2U);
  EXPECT_FALSE(pose->clock_was_set);
  EXPECT_NEAR(static_cast<double>((clock.now() - pose->arrived).count()), 21.0 * 10.0 / 115200.0 * 1e6, 1.0);
  EXPECT_EQ(pose->captured_at(), pose->arrived) << "nothing is known of its age yet";
  EXPECT_FALSE(pose->offset.known);
  EXPECT_EQ(link.receive(clock.now()).status(), core::Status::kNotReady);
}

// The aircraft turns and tilts about its centre of gravity, which stays: so must the position. Catches a lever that is
// added, or turned by the inverse, by the heading alone, or in the axes of the wire.
TEST_F(PoseLinkTest, ALeverArmTurnsWithTheAttitudeAndThePositionIsThatOfTheCentreOfGravity) {
  const LeverArm lever_b_m{0.3F, -0.1F, 0.2F};
  const core::Vector<float, 3> lever(lever_b_m[0], lever_b_m[1], lever_b_m[2]);
  for (const core::Euler<float>& euler :
       {core::Euler<float>{0.F, 0.F, 0.F}, {0.F, 0.F, 1.6F}, {0.4F, 0.F, -2.F}, {-0.1F, 0.5F, 3.F}}) {
    PoseLink leaning(cable.a(), 115200, nullptr, {}, {.offset_b_m = lever_b_m});
    const core::Quaternion<float> q = core::quaternion_of(euler);
    const core::Quaternion<float> wire = core::flip_yz(q);
    const core::Vector<float, 3> origin = core::flip_yz(core::Vector<float, 3>(core::rotation_of(q) * lever));
    write(AttPosMocap{.time_usec = 1000,
                      .q = {wire.w, wire.x, wire.y, wire.z},
                      .x = 1.F + origin.x(),
                      .y = -2.F + origin.y(),
                      .z = 0.5F + origin.z()});
    clock.advance(milliseconds(10));
    const core::Expected<core::Pose<double>> pose = leaning.receive(clock.now());
    ASSERT_TRUE(pose);
    EXPECT_LT((pose->position_w_m - core::Vector<double, 3>(1.0, 2.0, -0.5)).norm(), 1e-6) << euler.yaw_rad;
    EXPECT_NEAR(pose->yaw_rad, static_cast<double>(euler.yaw_rad), 1e-6);
  }
}

TEST_F(PoseLinkTest, DoubledAndOvertakenPosesAreRefused) {
  EXPECT_TRUE(send(50000000));
  EXPECT_FALSE(send(50000000));
  EXPECT_FALSE(send(49990000));
  EXPECT_EQ(link.stats().refused_order, 2U);
  EXPECT_TRUE(send(50010000));
  EXPECT_FALSE(after(milliseconds(1100)));
  const core::Expected<core::Pose<double>> pose = send(35000000);
  ASSERT_TRUE(pose) << "nothing was heard for a second";
  EXPECT_TRUE(pose->clock_was_set);
}

// Catches a counter that is compared across senders, or with that of a refused pose, one of the first pose, and a kind
// of message without a counter that is taken for a jump back to zero and forth.
TEST_F(PoseLinkTest, AnnouncedJumpsAreCountedByTheResetCounterOfOneSender) {
  std::uint64_t stamp_us = 50000000;
  const auto counted = [&](std::uint8_t counter, bool odometry, mavlink::Address from = kSender) {
    stamp_us += 40000;
    odometry
        ? write(mavlink::Odometry{.time_usec = stamp_us, .x = 1.F, .q = {1.F}, .frame_id = 1, .reset_counter = counter},
                from)
        : write(mavlink::VisionPositionEstimate{.usec = stamp_us, .x = 1.F, .reset_counter = counter}, from);
    (void)after(milliseconds(40));  // ODOMETRY takes 21 ms of the line
    return link.stats().announced_jumps;
  };
  EXPECT_EQ(counted(7, true), 0U) << "the first pose";
  EXPECT_EQ(counted(7, true), 0U);
  EXPECT_EQ(counted(8, true), 1U);
  EXPECT_EQ(counted(8, false), 1U);
  stamp_us += 40000;
  write(mavlink::AttPosMocap{.time_usec = stamp_us, .q = {1.F}, .x = 1.F}, kSender);
  (void)after(milliseconds(40));
  EXPECT_EQ(counted(8, true), 1U) << "a pose without a counter announces nothing";
  EXPECT_EQ(counted(255, false), 2U);
  EXPECT_EQ(counted(0, false), 3U) << "it wraps";
  EXPECT_EQ(counted(5, false, {.system = 10, .component = 1}), 3U) << "its poses are refused";
  EXPECT_EQ(counted(0, false), 3U);
  (void)after(milliseconds(1500));
  EXPECT_EQ(counted(5, false, {.system = 10, .component = 1}), 3U) << "another world from the beginning";
  EXPECT_EQ(link.stats().poses, 10U);
}

// Catches a variance that is compared on one axis only, a stated sigma that is ignored, and a NaN (not known) or a
// covariance of zeros that is refused.
TEST_F(PoseLinkTest, AVarianceThatTheFenceHasNoRoomForIsRefused) {
  const core::Fence fence{.side = {{{-3.0, 3.0}, {-6.0, 6.0}, {0.3, 4.2}}}};  // a sixth of the widths: 1, 2 and 0.65 m
  const auto accepts = [&](double stated_m, float x, float y, float z) {
    PoseLink fresh(cable.a(), 115200, nullptr, {}, PoseProperties::inside(fence, stated_m));
    AttPosMocap message = mocap(1000);
    message.covariance[0] = x, message.covariance[6] = y, message.covariance[11] = z;
    write(message);
    clock.advance(milliseconds(30));
    const core::Expected<core::Pose<double>> pose = fresh.receive(clock.now());
    EXPECT_EQ(fresh.stats().faults[static_cast<std::size_t>(PoseFault::kVariance)], pose ? 0U : 1U);
    EXPECT_TRUE(!pose || stated_m == 0.0 || pose->position_variance_m2.x() == stated_m * stated_m);
    return pose.has_value();
  };
  const float nan = std::nanf("");
  EXPECT_TRUE(accepts(0.0, nan, 0.F, 0.F));
  EXPECT_TRUE(accepts(0.0, 0.99F, 3.9F, 0.42F));
  EXPECT_FALSE(accepts(0.0, 1.01F, 0.1F, 0.1F));
  EXPECT_FALSE(accepts(0.0, 0.1F, 4.1F, 0.1F));
  EXPECT_FALSE(accepts(0.0, 1.F, 1.F, 1.F)) << "an identity covariance";
  EXPECT_TRUE(accepts(0.02, 1.F, 1.F, 1.F)) << "whose sigma the operator states";
}

TEST_F(PoseLinkTest, ARefusalIsCountedByItsKindAndDated) {
  AttPosMocap bad = mocap(1000);
  bad.q[0] = 0.9F;
  write(bad);
  EXPECT_EQ(after(milliseconds(10)).status(), core::Status::kNotReady);
  EXPECT_EQ(link.stats().refused, 1U);
  EXPECT_EQ(link.stats().refused_order + link.stats().refused_senders, 0U);
  EXPECT_EQ(link.stats().last_fault, PoseFault::kQuaternion);
  EXPECT_EQ(link.stats().last_fault_at, clock.now());
}

// The stamps, the clock and the tilt of the sender before say nothing of the next.
TEST_F(PoseLinkTest, AnotherSenderBeginsAnew) {
  for (int i = 0; i < 3; ++i) {
    const core::Expected<core::Pose<double>> pose = send(0);
    ASSERT_TRUE(pose.has_value()) << "it stamps nothing";
    EXPECT_EQ(pose->captured_at(), pose->arrived);
  }
  for (std::uint64_t i = 0; i < 40; ++i) {
    EXPECT_TRUE(send(50000000 + 10000 * i));
  }
  EXPECT_NEAR(link.up_b().z(), 1.F, 1e-6F);
  AttPosMocap banked = mocap(50400000);
  banked.q = {0.8F, 0.6F, 0.F, 0.F};
  write(banked);
  EXPECT_TRUE(after(milliseconds(10)));
  EXPECT_NEAR(link.up_b().z(), 1.F + (0.28F - 1.F) / 16.F, 1e-6F) << "a mean of sixteen";
  clock.advance(milliseconds(1100));
  for (int i = 0; i < 3; ++i) {
    banked.time_usec = 0;
    write(banked, {.system = 10, .component = 197});
    const core::Expected<core::Pose<double>> pose = after(milliseconds(10));
    ASSERT_TRUE(pose) << "it stamps nothing";
    EXPECT_FALSE(pose->clock_was_set);
    EXPECT_NEAR(link.up_b().z(), 0.28F, 1e-6F);
  }
}

// Would catch a link that refuses good poses until the stamps have reached the old ones, or for a fixed time.
TEST_F(PoseLinkTest, AClockThatWasSetCostsOnePoseAndASingleWrongStampOne) {
  std::uint64_t stamp_us = 50000000;
  const auto next = [&] { return send(stamp_us += 10000); };
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(next());
  }
  for (const std::int64_t set_us : {-20000, -25000, -154000, -303000, -9000000, 70000, 5000000, 20000000}) {
    stamp_us += static_cast<std::uint64_t>(set_us);
    EXPECT_FALSE(next()) << set_us;
    const core::Expected<core::Pose<double>> pose = next();
    ASSERT_TRUE(pose) << set_us;
    EXPECT_TRUE(pose->clock_was_set) << set_us;
    for (int i = 0; i < 100; ++i) {
      EXPECT_TRUE(next()) << set_us;
    }
  }
  for (const std::uint64_t ahead_us : {36000U, 300000U, 5000000U, 20000000U}) {
    stamp_us += 10000;
    EXPECT_FALSE(send(stamp_us + ahead_us));
    for (int i = 0; i < 100; ++i) {
      const core::Expected<core::Pose<double>> pose = next();
      ASSERT_TRUE(pose) << ahead_us;
      EXPECT_FALSE(pose->clock_was_set) << ahead_us;
    }
  }
}

// A stamp between two neighbours is that of a clock that was set; where two poses are missing, it may be an overtaken
// one.
struct StampOrderTest : ::testing::TestWithParam<std::tuple<bool, bool>> {
  StampOrder::Verdict judge(int stamp_ms, int now_ms) {
    return order.judge(core::SenderTime(milliseconds(stamp_ms)), frame++, core::TimePoint(milliseconds(now_ms)));
  }
  /// Poses of 100 Hz. @returns the verdict on the first; the others rise.
  StampOrder::Verdict feed(int count, int from_ms, bool has_gap) {
    const StampOrder::Verdict first = judge(1000, from_ms);
    for (int i = 1; i < count; ++i) {
      const bool is_missing = has_gap && (i == 10 || i == 11);
      EXPECT_TRUE(is_missing || judge(1000 + 10 * i, from_ms + 10 * i) == StampOrder::Verdict::kRises);
    }
    return first;
  }
  StampOrder order;
  std::uint8_t frame = 0;
};
INSTANTIATE_TEST_SUITE_P(All, StampOrderTest, ::testing::Combine(::testing::Bool(), ::testing::Bool()));

TEST_P(StampOrderTest, AStampInAGapMayBeAnOvertakenOne) {
  using Verdict = StampOrder::Verdict;
  const auto [has_gap, is_second] = GetParam();
  if (is_second) {  // the stamps and numbers of a sender that is gone are forgotten
    EXPECT_EQ(feed(31, 0, false), Verdict::kRises);
    frame = static_cast<std::uint8_t>(frame + 200);
  }
  EXPECT_EQ(feed(21, 2000, has_gap), is_second ? Verdict::kSet : Verdict::kRises);
  EXPECT_EQ(judge(1105, 2210), Verdict::kRefused);
  EXPECT_EQ(judge(1115, 2220), has_gap ? Verdict::kRefused : Verdict::kSet);
}

TEST_P(StampOrderTest, ALeapOfHalfTheFrameNumbersIsALaterFrame) {
  const bool is_later = std::get<0>(GetParam());
  EXPECT_EQ(feed(11, 2000, false), StampOrder::Verdict::kRises);
  frame = static_cast<std::uint8_t>(10 + (is_later ? 127 : 128));
  EXPECT_EQ(judge(1050, 2110), StampOrder::Verdict::kRefused);
  EXPECT_EQ(judge(1060, 2120), is_later ? StampOrder::Verdict::kSet : StampOrder::Verdict::kRefused);
}

// Would catch a link that takes a sender without frame numbers for one whose poses are overtaken for ever.
TEST_F(PoseLinkTest, WhatRisesAmongItselfIsRefusedForAFifthOfASecond) {
  const auto unnumbered = [&](std::uint64_t stamp_us) {
    frames = 7;
    return send(stamp_us);
  };
  EXPECT_TRUE(unnumbered(50000000));
  int refused = 0;
  for (std::uint64_t i = 1; !unnumbered(40000000 + 10000 * i) && refused < 100; ++i) {
    ++refused;
  }
  EXPECT_EQ(refused, 20);
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(unnumbered(40000000)) << "a stamp that does not rise";
  }
}

TEST_F(PoseLinkTest, OneSenderIsHeardUntilItIsGone) {
  clock.advance(std::chrono::seconds(5));
  EXPECT_TRUE(send(1000));
  write(mocap(2000), {.system = 10, .component = 197});
  EXPECT_FALSE(after(milliseconds(10)));
  EXPECT_EQ(link.stats().refused_senders, 1U);
  write(mocap(3000), {.system = 10, .component = 197});
  EXPECT_FALSE(after(milliseconds(990))) << "a second after its pose";
  write(mocap(500), {.system = 10, .component = 197});
  EXPECT_TRUE(after(milliseconds(5)));
}

// Would catch a link that a stray pose locks out, and one that chooses by who came first although a choice was made.
TEST_F(PoseLinkTest, TheChosenSenderIsHeardWhoeverElseSends) {
  PoseLink chosen(cable.a(), 115200, nullptr, {.system = 9, .component = 197});
  std::uint64_t stamp_us = 1000;
  int taken = 0;
  for (int i = 0; i < 300; ++i) {
    write(mocap(stamp_us += 7), {.system = 9, .component = 100});
    if (i >= 100) {
      write(mocap(stamp_us + 10000 * static_cast<std::uint64_t>(i)));
    }
    clock.advance(milliseconds(10));
    taken += chosen.receive(clock.now()).has_value() ? 1 : 0;
  }
  EXPECT_EQ(taken, 200);
  EXPECT_EQ(chosen.sender().component, 197);
  EXPECT_EQ(chosen.rival(clock.now()), nullptr) << "the operator has chosen";
  ASSERT_EQ(chosen.senders().all().size(), 2U);
  EXPECT_EQ(chosen.senders().all()[0].poses, 300U);
  EXPECT_NEAR(chosen.senders().all()[0].rate_hz(), 100.0, 0.01);
  ASSERT_NE(chosen.senders().find({.system = 9, .component = 197}), nullptr);
  EXPECT_EQ(chosen.senders().find({.system = 9, .component = 197})->poses, 200U);
  EXPECT_EQ(chosen.senders().find({.system = 9, .component = 198}), nullptr);
  EXPECT_EQ(chosen.stats().faults[static_cast<std::size_t>(PoseFault::kSender)], 300U);
}

TEST_F(PoseLinkTest, ASecondSenderIsARivalForAsLongAsItSends) {
  EXPECT_TRUE(send(1000));
  EXPECT_EQ(link.rival(clock.now()), nullptr);
  write(mocap(500), {.system = 2, .component = 197});
  (void)after(milliseconds(10));
  ASSERT_NE(link.rival(clock.now()), nullptr);
  EXPECT_EQ(link.rival(clock.now())->from.system, 2);
  clock.advance(std::chrono::seconds(2));
  EXPECT_NE(link.rival(clock.now()), nullptr);
  clock.advance(core::Duration{1});
  EXPECT_EQ(link.rival(clock.now()), nullptr);
  PoseSenders many;
  for (std::uint8_t system = 1; system < 20; ++system) {
    many.add({.system = system, .component = 1}, clock.now());
  }
  EXPECT_EQ(many.all().size(), 8U);
  EXPECT_EQ(many.all()[7].rate_hz(), 0.0) << "of one pose";
}

// Would catch stamps in another unit that are flown by the times of arrival.
TEST_F(PoseLinkTest, StampsInAnotherUnitAreNamed) {
  for (const auto& [step_us, fault] : {std::pair{10000000U, PoseFault::kFastStamp}, {10U, PoseFault::kSlowStamp}}) {
    PoseLink fresh(cable.a(), 115200);
    for (std::uint64_t i = 1; i <= 200; ++i) {
      write(mocap(kUnix_us + step_us * i));
      clock.advance(milliseconds(10));
      const bool taken = fresh.receive(clock.now()).has_value();
      EXPECT_FALSE(i > 70 && taken) << step_us;
    }
    EXPECT_EQ(fresh.stats().faults[static_cast<std::size_t>(fault)], 140U);
    write(mocap(kUnix_us), {.system = 10, .component = 197});
    clock.advance(milliseconds(10));
    EXPECT_TRUE(fresh.receive(clock.now())) << "the unit of another sender is not known yet";
  }
  struct Case {
    std::int64_t step_us;
    PoseFault fault;
  };
  for (const Case& one :
       {Case{4500010, PoseFault::kFastStamp}, Case{4500000, PoseFault::kNone}, Case{-4500010, PoseFault::kFastStamp},
        Case{-5000, PoseFault::kNone}, Case{5000, PoseFault::kNone}, Case{4999, PoseFault::kSlowStamp}}) {
    StampUnit unit;
    for (int i = 0; i < 20; ++i) {  // the fewest poses of a window, and the factor of 30 in time
      const PoseFault named = unit.judge(core::SenderTime(core::SenderClock::duration(one.step_us * i)),
                                         core::TimePoint(milliseconds(150 * i)));
      EXPECT_EQ(named, i < 6 ? PoseFault::kNone : one.fault) << one.step_us << " " << i;
    }
  }
}

TEST_F(PoseLinkTest, LostFramesAreCounted) {
  EXPECT_TRUE(send(1000));
  frames += 3;
  EXPECT_TRUE(send(2000));
  EXPECT_EQ(link.stats().lost_frames, 3U);
  frames += 126;
  EXPECT_TRUE(send(3000));
  EXPECT_EQ(link.stats().lost_frames, 129U);
  frames += 127;
  EXPECT_TRUE(send(4000));
  EXPECT_EQ(link.stats().lost_frames, 129U) << "another count";
}

TEST_F(PoseLinkTest, OtherMessagesOfTheSenderAreNotLostPoses) {
  EXPECT_TRUE(send(1000));
  write(mavlink::Heartbeat{});
  write(mavlink::Timesync{.tc1 = 0, .ts1 = 5});
  EXPECT_TRUE(send(2000));
  EXPECT_EQ(link.stats().lost_frames, 0U);
  EXPECT_EQ(link.senders().all()[0].poses, 2U);
}

/// A sender whose clock is kUnix_us ahead of ours answers a question; `out` and `back` are the delays of the two
/// directions.
struct TimesyncTest : PoseLinkTest {
  void exchange(core::Duration out, core::Duration back) {
    EXPECT_TRUE(send(kUnix_us + static_cast<std::uint64_t>(clock.now().time_since_epoch().count())));
    link.request_time(clock.now());
    clock.advance(out);
    std::array<std::byte, 64> bytes;
    const std::size_t count = cable.b().read(bytes).value_or(0);
    mavlink::Parser parser;
    ASSERT_EQ(parser.push(std::span(bytes).first(count)), count);
    const core::Expected<mavlink::FrameView> question = parser.poll();
    ASSERT_TRUE(question.has_value());
    ASSERT_TRUE(mavlink::is<Timesync>(*question));
    EXPECT_EQ(mavlink::decode<Timesync>(*question).tc1, 0);
    EXPECT_TRUE(question->from == (mavlink::Address{.system = 1, .component = 191}));
    EXPECT_LE(question->bytes.size(), 80U);
    const auto own_us = static_cast<std::int64_t>(kUnix_us) + clock.now().time_since_epoch().count();
    write(Timesync{.tc1 = own_us * 1000, .ts1 = mavlink::decode<Timesync>(*question).ts1});
    (void)after(back);
  }
  core::ClockOffset offset() {
    const core::Expected<core::Pose<double>> pose =
        send(kUnix_us + static_cast<std::uint64_t>(clock.now().time_since_epoch().count()));
    return pose ? pose->offset : core::ClockOffset{};
  }
};

TEST_F(TimesyncTest, AnAnswerTellsTheOffsetToHalfOfThereAndBack) {
  exchange(milliseconds(5), milliseconds(5));
  const core::ClockOffset found = offset();
  EXPECT_TRUE(found.known);
  EXPECT_EQ(link.stats().answers, 1U);
  EXPECT_NEAR(static_cast<double>(found.to_ours.count()), -static_cast<double>(kUnix_us), 10.0);
  EXPECT_NEAR(core::seconds<double>(found.bound), 0.005, 1e-4);
  clock.advance(milliseconds(1100));
  write(mocap(500), {.system = 10, .component = 197});
  const core::Expected<core::Pose<double>> other = after(milliseconds(10));
  ASSERT_TRUE(other);
  EXPECT_FALSE(other->offset.known || other->clock_was_set) << "of another sender nothing is known";
}

// Would catch an estimate that takes half of the round trip for the truth: the age would be wrong by 45 ms and still be
// called known.
void expect_truth_inside_the_bound(const core::ClockOffset& found) {
  ASSERT_TRUE(found.known);
  const double wrong_s = std::abs(core::seconds<double>(found.to_ours + core::Duration(kUnix_us)));
  EXPECT_NEAR(wrong_s, 0.045, 0.001);
  EXPECT_GE(core::seconds<double>(found.bound), wrong_s);
}
TEST_F(TimesyncTest, ALongerWayThereStaysInsideTheBound) {
  exchange(milliseconds(95), milliseconds(5));
  expect_truth_inside_the_bound(offset());
}
TEST_F(TimesyncTest, ALongerWayBackStaysInsideTheBound) {
  exchange(milliseconds(5), milliseconds(95));
  expect_truth_inside_the_bound(offset());
}

TEST_F(TimesyncTest, ABetterAnswerCountsAndAWorseOneDoesNot) {
  exchange(milliseconds(60), milliseconds(5));
  clock.advance(milliseconds(200));
  exchange(milliseconds(5), milliseconds(5));
  EXPECT_NEAR(core::seconds<double>(offset().bound), 0.005, 1e-3);
  clock.advance(milliseconds(200));
  exchange(milliseconds(60), milliseconds(5));
  EXPECT_NEAR(core::seconds<double>(offset().bound), 0.005, 1e-3);
}

/// 240 poses a second of 48 bytes fill 115200 baud. With five answers a second in addition, poses once came 12 ms later
/// every second, and the flight ended in the failsafe after twenty seconds.
TEST_F(TimesyncTest, AFullLineIsNotAskedForMore) {
  exchange(milliseconds(5), milliseconds(5));
  std::uint32_t questions = 0;
  const auto fly = [&](core::Duration spacing) {
    questions = 0;
    for (int i = 0; i < 480; ++i) {
      EXPECT_TRUE(after(spacing).status() != core::Status::kOutOfRange);
      write(mocap(kUnix_us + static_cast<std::uint64_t>(clock.now().time_since_epoch().count())));
      link.request_time(clock.now());
      std::array<std::byte, 128> bytes;
      const std::size_t count = cable.b().read(bytes).value_or(0);
      questions += count > 0 ? 1U : 0U;
    }
  };
  fly(std::chrono::microseconds(4167));
  EXPECT_LE(questions, 1U) << "in two seconds of a full line";
  fly(milliseconds(10));
  EXPECT_GE(questions, 20U) << "in 4.8 s of a line that is less than half full";
}

// MAVROS asks for our time ten times a second, and warns if nobody answers.
TEST_F(TimesyncTest, TheSendersQuestionIsAnsweredWithOurTimeAndNobodyElsesIs) {
  ASSERT_TRUE(send(kUnix_us));
  const auto answers_to = [&](std::int64_t ts1, mavlink::Address from) {
    write(Timesync{.tc1 = 0, .ts1 = ts1}, from);
    (void)after(milliseconds(10));
    clock.advance(milliseconds(10));
    std::vector<Timesync> answers;
    std::array<std::byte, 64> bytes;
    mavlink::Parser parser;
    parser.consume(std::span(bytes).first(cable.b().read(bytes).value_or(0)),
                   [&](const mavlink::FrameView& frame) { answers.push_back(mavlink::decode<Timesync>(frame)); });
    return answers;
  };
  const std::int64_t ours_ns = (clock.now() + milliseconds(10)).time_since_epoch().count() * 1000;
  const std::vector<Timesync> answers = answers_to(1'700'000'000'123'456'000, kSender);
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(answers.front().ts1, 1'700'000'000'123'456'000);
  EXPECT_EQ(answers.front().tc1, ours_ns);
  EXPECT_TRUE(answers_to(5, {.system = 3, .component = 1}).empty());
}

TEST_F(TimesyncTest, AnswersToNobodysQuestionArePassedOver) {
  EXPECT_TRUE(send(kUnix_us));
  write(Timesync{.tc1 = 5, .ts1 = 12345});
  (void)after(milliseconds(10));
  EXPECT_EQ(link.stats().answers, 0U);
  link.request_time(clock.now());
  write(Timesync{.tc1 = 5, .ts1 = clock.now().time_since_epoch().count() * 1000}, {.system = 3, .component = 1});
  (void)after(milliseconds(10));
  EXPECT_EQ(link.stats().answers, 0U) << "of a stranger";
}

}  // namespace
}  // namespace m100::link
