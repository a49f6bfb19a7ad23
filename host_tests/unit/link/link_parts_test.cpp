// SPDX-License-Identifier: BSD-3-Clause
// The small parts of the link, each alone: what a channel sends, how often, and in which order frames are sent.
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "firmware/link/ack_condition.h"
#include "firmware/link/command_channel.h"
#include "firmware/link/false_header_detector.h"
#include "firmware/link/line_time.h"
#include "firmware/link/mode_switch.h"
#include "firmware/link/outbox.h"
#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "protocol/dji/catalogue.h"
#include "protocol/dji/frame_encoder.h"

namespace m100::link {
namespace {

using core::Duration;
using core::TimePoint;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(LineTime, IsTenBitsAByte) {
  EXPECT_EQ(line_time(23040, 230400), std::chrono::seconds(1));
  EXPECT_EQ(line_time(1, 230400), microseconds(43));
  EXPECT_EQ(line_time(100, 0), Duration{0});
  // Around the limit of 32 bits, and the largest number of bytes that is asked for.
  for (const std::uint64_t bytes :
       {std::uint64_t{428}, std::uint64_t{429}, std::uint64_t{430}, std::uint64_t{1} << 40U}) {
    const std::uint64_t expected_us = bytes * 10 * 1000000 / 9600;
    EXPECT_EQ(line_time(bytes, 9600), microseconds(static_cast<std::int64_t>(expected_us))) << bytes;
  }
}

// The windows of protocol, sections 6.4 and 7, at their edges.
TEST(CommandPeriod, TakesTheRatesOfItsChannelOnly) {
  const auto period = [](Channel channel, double rate_hz) {
    return command_period({.channel = channel, .rate_hz = rate_hz});
  };
  EXPECT_EQ(*period(Channel::kVirtualRc, 0.0), milliseconds(40));
  EXPECT_EQ(*period(Channel::kVirtualRc, 25.0), milliseconds(40));
  EXPECT_EQ(*period(Channel::kVirtualRc, 5.0), milliseconds(200));
  EXPECT_EQ(period(Channel::kVirtualRc, 25.01).status(), core::Status::kOutOfRange);
  EXPECT_EQ(period(Channel::kVirtualRc, 4.99).status(), core::Status::kOutOfRange);
  EXPECT_EQ(*period(Channel::kMovement, 0.0), milliseconds(20));
  EXPECT_EQ(*period(Channel::kMovement, 50.0), milliseconds(20));
  EXPECT_EQ(*period(Channel::kMovement, 1.0), std::chrono::seconds(1));
  EXPECT_EQ(period(Channel::kMovement, 50.01).status(), core::Status::kOutOfRange);
  EXPECT_EQ(period(Channel::kMovement, 0.99).status(), core::Status::kOutOfRange);
  EXPECT_EQ(period(Channel::kMovement, -5.0).status(), core::Status::kOutOfRange);
  EXPECT_EQ(period(Channel::kMovement, std::numeric_limits<double>::quiet_NaN()).status(), core::Status::kOutOfRange);
  EXPECT_EQ(*period(Channel::kMovement, 30.0), microseconds(33334)) << "rounded up: never faster than asked for";
  for (const Channel channel : {Channel::kVirtualRc, Channel::kMovement}) {
    EXPECT_EQ(*command_period({.channel = channel, .rate_hz = 7.0, .paper_100_hz = true}), milliseconds(10));
  }
}

TEST(ToVirtualRc, PutsEachStickIntoItsChannel) {
  const protocol::VirtualRcData data = to_virtual_rc(
      {.roll = vrc::Stick{400}, .pitch = vrc::Stick{500}, .throttle = vrc::Stick{600}, .yaw = vrc::Stick{700}});
  const std::array<std::uint32_t, 16> wanted{400,  500,  600,  700,  1324, 1024, 1024, 1024,
                                             1024, 1024, 1024, 1024, 1024, 1024, 1024, 1024};
  EXPECT_EQ(data.channels, wanted);
}

// The message has degrees, nose up and clockwise positive. Values beyond a range are limited; values that are not
// numbers are refused later.
TEST(ToMovement, TurnsSignsAndUnitsAndSaturates) {
  const auto near = [](const protocol::Movement& m, float x, float y, float z, float yaw) {
    EXPECT_EQ(m.flag, 0x0A);
    EXPECT_NEAR(m.x, x, 1e-5F);
    EXPECT_NEAR(m.y, y, 1e-5F);
    EXPECT_NEAR(m.z, z, 1e-5F);
    EXPECT_NEAR(m.yaw, yaw, 1e-5F);
  };
  const double degree = 3.14159265358979323846 / 180.0;
  near(to_movement(
           {.roll_rad = 10.0 * degree, .pitch_rad = 20.0 * degree, .climb_m_s = 1.5, .yaw_rate_rad_s = 30.0 * degree}),
       10.F, -20.F, 1.5F, -30.F);
  near(to_movement({.roll_rad = 1.0, .pitch_rad = 1.0, .climb_m_s = 9.0, .yaw_rate_rad_s = 9.0}), 30.F, -30.F, 4.F,
       -100.F);
  near(to_movement({.roll_rad = -1.0, .pitch_rad = -1.0, .climb_m_s = -9.0, .yaw_rate_rad_s = -9.0}), -30.F, 30.F, -4.F,
       100.F);
}

TEST(AckCondition, IsTheVerdictButForTwoCodes) {
  using protocol::AckVerdict;
  using safety::AuthorityCondition;
  const auto of = [](std::uint16_t code, AckVerdict verdict, protocol::MessageId command) {
    return condition_of({.code = code, .name = {}, .verdict = verdict, .remedy = {}}, command);
  };
  const protocol::MessageId ours = protocol::ids::kControlRequest, other = protocol::ids::kActivation;
  for (const protocol::MessageId command : {ours, other}) {
    EXPECT_EQ(of(9, AckVerdict::kDone, command), AuthorityCondition::kDone);
    EXPECT_EQ(of(9, AckVerdict::kSendAgain, command), AuthorityCondition::kSendAgain);
    EXPECT_EQ(of(9, AckVerdict::kRetry, command), AuthorityCondition::kRetry);
    EXPECT_EQ(of(9, AckVerdict::kRefused, command), AuthorityCondition::kRefused);
    EXPECT_EQ(of(protocol::kAckNotAuthorised, AckVerdict::kDone, command), AuthorityCondition::kNotActivated);
  }
  EXPECT_EQ(of(protocol::control_ack::kReleased, AckVerdict::kDone, ours), AuthorityCondition::kRefused);
  EXPECT_EQ(of(protocol::control_ack::kReleased, AckVerdict::kDone, other), AuthorityCondition::kDone);
  EXPECT_FALSE(awaits_ack_of(safety::AuthorityStage::kReady, ours));
}

// The RC item shows the transmitter for ever once it shows F 200 ms after the first command of mode A.
TEST(ModeSwitch, TrustsTheRcItemOnceItHasShownTheTransmitter) {
  constexpr auto kRc = static_cast<std::uint16_t>(protocol::TelemetryItem::kRc);
  for (const int after_ms : {0, 199, 200}) {
    for (const bool commands : {false, true}) {
      for (const std::uint16_t items : {std::uint16_t{0}, kRc}) {
        ModeSwitch mode;
        protocol::Telemetry telemetry;
        telemetry.control.bits = 16;  // Virtual RC is on
        telemetry.rc.mode = protocol::kRcModeF;
        if (commands) {
          mode.sent(TimePoint{seconds(3)});
          mode.sent(TimePoint{seconds(3)} + milliseconds(after_ms));
        }
        mode.update(telemetry, items, TimePoint{seconds(3)} + milliseconds(after_ms));
        EXPECT_TRUE(mode.is_f(telemetry, true));
        telemetry.rc.mode = protocol::kRcModeA;
        EXPECT_EQ(mode.is_f(telemetry, true), !(commands && items == kRc && after_ms == 200)) << after_ms;
        EXPECT_FALSE(mode.is_f(telemetry, false));
        mode.reset();
        mode.end_commands();
        EXPECT_TRUE(mode.is_f(telemetry, true));
        telemetry.rc.mode = protocol::kRcModeF;
        mode.update(telemetry, kRc, TimePoint{seconds(9)});
        telemetry.rc.mode = protocol::kRcModeA;
        EXPECT_TRUE(mode.is_f(telemetry, true)) << "no command was sent since";
      }
    }
  }
}

/// A parser that has found a header with the length `size`, `behind` bytes after the beginning.
protocol::FrameParser waiting_for(std::size_t size, std::size_t behind = 0) {
  std::vector<std::byte> space(300);
  const std::vector<std::byte> value(size - protocol::kHeaderBytes - 4 - 2);
  const protocol::MessageId id{1, 1};
  const auto frame =
      protocol::encode_frame({.session = 0, .is_ack = false, .encrypted = false, .sequence = 1}, &id, value, space);
  EXPECT_EQ(frame->size(), size);
  protocol::FrameParser parser{protocol::kMaxAutopilotFrameBytes};
  EXPECT_EQ(parser.push(std::vector<std::byte>(behind)), behind);
  EXPECT_EQ(parser.push(frame->first(protocol::kHeaderBytes)), protocol::kHeaderBytes);
  EXPECT_FALSE(parser.poll());
  return parser;
}

TEST(FalseHeaderDetector, GivesUpWhatNoAutopilotSendsAndWhatIsOverdue) {
  constexpr std::uint32_t kBaud = 230400;
  FalseHeaderDetector nothing(kBaud);
  EXPECT_FALSE(nothing.is_false(protocol::FrameParser{}, TimePoint{}, Duration{0}));
  EXPECT_EQ(waiting_for(160).claimed_bytes(), 160U);
  EXPECT_EQ(waiting_for(161).claimed_bytes(), 0U);
  EXPECT_EQ(waiting_for(161).stats().length_errors, 1U);
  const protocol::FrameParser parser = waiting_for(144);
  FalseHeaderDetector late(kBaud);
  const Duration due = line_time(144, kBaud) + milliseconds(16);
  EXPECT_FALSE(late.is_false(parser, TimePoint{milliseconds(100)}, milliseconds(16)));
  EXPECT_FALSE(late.is_false(parser, TimePoint{milliseconds(100) + due}, milliseconds(16)));
  EXPECT_TRUE(late.is_false(parser, TimePoint{milliseconds(100) + due + Duration{1}}, milliseconds(16)));
  EXPECT_FALSE(late.is_false(waiting_for(144, 1), TimePoint{milliseconds(100) + due + Duration{1}}, milliseconds(16)));
}

std::vector<std::byte> frame_of(std::size_t size, int mark) { return std::vector<std::byte>(size, std::byte(mark)); }

struct OutboxTest : ::testing::Test {
  hal::ManualClock clock;
  hal::UartPair pair{clock, 0};
  Outbox outbox;
  std::size_t sent_bytes = 0;

  /// All bytes that one call sends, as marks.
  std::vector<int> flushed() {
    EXPECT_EQ(outbox.flush(pair.a(), [&](std::span<const std::byte> bytes) { sent_bytes += bytes.size(); }),
              core::Status::kOk);
    std::array<std::byte, 4096> got;
    const std::size_t count = pair.b().read(got).value();
    std::vector<int> marks;
    for (std::size_t i = 0; i < count; ++i) {
      marks.push_back(std::to_integer<int>(got[i]));
    }
    return marks;
  }
};

TEST_F(OutboxTest, RequestsGoFirstInTheirOrder) {
  EXPECT_FALSE(outbox.has_requests() || outbox.has_command());
  ASSERT_TRUE(outbox.set_command(frame_of(1, 9)));
  ASSERT_TRUE(outbox.add_request(frame_of(2, 1)));
  ASSERT_TRUE(outbox.add_answer(frame_of(1, 2)));
  EXPECT_TRUE(outbox.has_requests() && outbox.has_command());
  EXPECT_EQ(flushed(), (std::vector<int>{1, 1, 2, 9}));
  EXPECT_EQ(sent_bytes, 4U);
  EXPECT_FALSE(outbox.has_requests() || outbox.has_command());
  EXPECT_TRUE(flushed().empty());
}

TEST_F(OutboxTest, TakesEightRequestsAndOneCommandOfAtMost160Bytes) {
  for (int i = 0; i < 8; ++i) {
    EXPECT_TRUE(outbox.add_request(frame_of(1, i)));
  }
  EXPECT_FALSE(outbox.add_request(frame_of(1, 8)));
  EXPECT_FALSE(outbox.add_answer(frame_of(1, 8)));
  ASSERT_TRUE(outbox.set_command(frame_of(1, 9)));
  EXPECT_EQ(flushed(), (std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 9})) << "all nine in one call";
  EXPECT_TRUE(outbox.add_request(frame_of(160, 1)));
  EXPECT_FALSE(outbox.add_request(frame_of(161, 1)));
  EXPECT_TRUE(outbox.set_command(frame_of(160, 2)));
  EXPECT_FALSE(outbox.set_command(frame_of(161, 2)));
  EXPECT_EQ(flushed().size(), 320U);
}

TEST_F(OutboxTest, TheNewerCommandReplacesTheOlderUntilThatHasBegunToLeave) {
  ASSERT_TRUE(outbox.set_command(frame_of(4, 1)));
  ASSERT_TRUE(outbox.set_command(frame_of(4, 2)));
  pair.a_to_b().set_faults({.longest_write = 3});
  EXPECT_EQ(flushed(), (std::vector<int>{2, 2, 2}));
  EXPECT_FALSE(outbox.set_command(frame_of(4, 3))) << "frames never mix";
  ASSERT_TRUE(outbox.add_request(frame_of(2, 7)));
  EXPECT_EQ(flushed(), (std::vector<int>{2, 7, 7})) << "the begun command is finished first";
  ASSERT_TRUE(outbox.set_command(frame_of(2, 4)));
  EXPECT_EQ(flushed(), (std::vector<int>{4, 4}));
}

TEST_F(OutboxTest, DropsRequestsButKeepsAnswersInTheirOrder) {
  for (int i = 0; i < 6; ++i) {  // so that the queue's ring wraps
    ASSERT_TRUE(outbox.add_request(frame_of(1, 0)));
  }
  ASSERT_EQ(flushed().size(), 6U);
  ASSERT_TRUE(outbox.add_request(frame_of(1, 1)));
  ASSERT_TRUE(outbox.add_answer(frame_of(1, 2)));
  ASSERT_TRUE(outbox.add_request(frame_of(1, 3)));
  ASSERT_TRUE(outbox.add_answer(frame_of(1, 4)));
  ASSERT_TRUE(outbox.set_command(frame_of(1, 9)));
  outbox.drop_requests();
  EXPECT_EQ(flushed(), (std::vector<int>{2, 4, 9}));
  ASSERT_TRUE(outbox.add_request(frame_of(1, 1)));
  ASSERT_TRUE(outbox.set_command(frame_of(1, 9)));
  outbox.drop_command();
  EXPECT_EQ(flushed(), (std::vector<int>{1}));
  ASSERT_TRUE(outbox.add_answer(frame_of(1, 1)));
  ASSERT_TRUE(outbox.set_command(frame_of(1, 9)));
  outbox.drop_all();
  EXPECT_TRUE(flushed().empty());
}

TEST_F(OutboxTest, SaysWhatTheUartSays) {
  ASSERT_TRUE(outbox.set_command(frame_of(1, 1)));
  pair.set_plugged(false);
  EXPECT_EQ(outbox.flush(pair.a(), [](std::span<const std::byte>) {}), core::Status::kUnavailable);
  EXPECT_TRUE(outbox.has_command());
}

}  // namespace
}  // namespace m100::link
