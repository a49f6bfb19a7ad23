// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/image/order_tap.h"

#include <gtest/gtest.h>

#include <array>
#include <initializer_list>
#include <vector>

#include "firmware/app/image/board_course.h"
#include "firmware/app/image/tick_schedule.h"
#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::app {
namespace {

// Would catch: a board that takes control because it was powered up, or restarted by its watchdog, while the switch was
// on.
TEST(OrderSwitch, OnlyItsMovementIsAnOrder) {
  RecordProperty("promise", "R4");
  OrderSwitch on_from_the_start;
  EXPECT_EQ(on_from_the_start.set(true), Order::kNone);
  EXPECT_EQ(on_from_the_start.set(true), Order::kNone);
  EXPECT_EQ(on_from_the_start.set(false), Order::kRelease);
  EXPECT_EQ(on_from_the_start.set(false), Order::kNone);
  EXPECT_EQ(on_from_the_start.set(true), Order::kEngage);
  EXPECT_EQ(on_from_the_start.set(true), Order::kNone);
}

struct OrderLineTest : ::testing::Test {
  hal::ManualClock clock;
  hal::UartPair pair{clock, 0};
  OrderTap<hal::Uart> line{pair.a()};

  std::vector<std::byte> pass(std::span<const std::byte> bytes) {
    EXPECT_EQ(pair.b().write(bytes).value_or(0), bytes.size());
    std::vector<std::byte> got(bytes.size());
    EXPECT_EQ(line.read(got).value_or(0), bytes.size());
    return got;
  }
};

TEST_F(OrderLineTest, HearsTheSwitchBetweenPosesAndPassesEveryByteOn) {
  const mavlink::Frame frame = mavlink::encode(mavlink::AttPosMocap{.time_usec = 7}, {1, 197}, 7);
  const std::span<const std::byte> pose = frame.bytes();
  std::vector<std::byte> stream(pose.begin(), pose.end());
  for (const bool position : {false, true}) {
    const protocol::OrderBytes order = protocol::encode_order(position);
    stream.insert(stream.end(), order.begin(), order.end());
    stream.insert(stream.end(), pose.begin(), pose.end());
  }
  EXPECT_EQ(line.take(), Order::kNone);
  EXPECT_EQ(pass(stream), stream);
  EXPECT_EQ(line.take(), Order::kRelease) << "the earlier movement first";
  EXPECT_EQ(line.take(), Order::kEngage);
  EXPECT_EQ(line.take(), Order::kNone) << "and each counts once";
}

// Catches a wrapper that does not pass on the bytes to send, or the line's error counts.
TEST_F(OrderLineTest, SendsAndCountsErrorsAsTheLineDoes) {
  const std::array sent{std::byte{1}, std::byte{2}, std::byte{3}};
  ASSERT_EQ(line.write(sent).value_or(0), sent.size());
  std::array<std::byte, 3> came{};
  EXPECT_EQ(pair.b().read(came).value_or(0), sent.size());
  EXPECT_EQ(came, sent);
  ASSERT_EQ(line.line_errors().has_value(), pair.a().line_errors().has_value());
  EXPECT_TRUE(line.line_errors().value_or(hal::LineErrors{}) == pair.a().line_errors().value_or(hal::LineErrors{}));
}

// Catches an order to stop that is lost because the switch bounced or was turned on again between two ticks, and an
// order to fly that survives a later order to stop.
TEST_F(OrderLineTest, AnOrderToStopIsNeverLost) {
  RecordProperty("promise", "R4");
  const auto move = [this](std::initializer_list<bool> positions) {
    for (const bool position : positions) {
      (void)pass(protocol::encode_order(position));
    }
  };
  move({false, true});
  (void)line.take();
  ASSERT_EQ(line.take(), Order::kEngage);
  move({false, true, false, true});
  EXPECT_EQ(line.take(), Order::kRelease);
  EXPECT_EQ(line.take(), Order::kEngage);
  move({false, true, false});
  EXPECT_EQ(line.take(), Order::kRelease);
  EXPECT_EQ(line.take(), Order::kNone);
}

// Catches a board that catches up after a stall of half a second by fifty ticks at once.
TEST(OwnTime, IsCountedAnewAfterAStall) {
  RecordProperty("promise", "R9");
  using std::chrono::milliseconds;
  const core::TimePoint due{milliseconds(1000)};
  EXPECT_EQ(tick_after(due, due), due + milliseconds(10));
  EXPECT_EQ(tick_after(due, due + milliseconds(20)), due + milliseconds(10)) << "made good";
  EXPECT_EQ(tick_after(due, due + milliseconds(21)), due + milliseconds(31));
  EXPECT_EQ(tick_after(due, due + milliseconds(500)), due + milliseconds(510));
}

// Catches a board that flies without a fence, or one whose courses leave it.
TEST(BoardFence, HoldsTheCoursesOfTheBoard) {
  RecordProperty("promise", "R16");
  for (const char* const name : {"hover", "step", "trajectory"}) {
    ref::Trajectory<float> course;
    EXPECT_EQ(append_board_course("loop", course), core::Status::kInvalidArgument) << "there is none of this name";
    ASSERT_EQ(append_board_course(name, course), core::Status::kOk);
    course.start(core::TimePoint{});
    for (core::TimePoint at{}; !course.finished(at); at += std::chrono::milliseconds(50)) {
      const ref::Window<float> window = course.window(at, core::Duration{0});
      const std::array<float, 3> place{window.x[0].position_m, window.y[0].position_m, window.height.position_m};
      for (std::size_t axis = 0; axis < place.size(); ++axis) {
        ASSERT_GT(place[axis], kBoardFence.side[axis].low_m + 0.5) << name;
        ASSERT_LT(place[axis], kBoardFence.side[axis].high_m - 0.5) << name;
      }
    }
  }
}

// Catches an order message that is accepted although one bit has flipped. The message is short, so every bit is tried.
TEST_F(OrderLineTest, NoSingleFlippedBitIsAnOrder) {
  (void)pass(protocol::encode_order(false));
  EXPECT_EQ(line.take(), Order::kRelease);
  for (std::size_t bit = 0; bit < 8 * protocol::kOrderMessageBytes; ++bit) {
    protocol::OrderBytes damaged = protocol::encode_order(true);
    damaged[bit / 8] ^= std::byte{1} << (bit % 8);
    (void)pass(damaged);
    EXPECT_EQ(line.take(), Order::kNone) << "bit " << bit;
  }
  (void)pass(protocol::encode_order(true));
  EXPECT_EQ(line.take(), Order::kEngage);
}

TEST_F(OrderLineTest, ThePoseParserPassesOverOrders) {
  mavlink::Parser parser;
  int poses = 0;
  const mavlink::Frame pose = mavlink::encode(mavlink::AttPosMocap{.time_usec = 7}, {1, 197}, 7);
  for (int i = 0; i < 10; ++i) {
    parser.consume(protocol::encode_order(true), [](const mavlink::FrameView&) { ADD_FAILURE(); });
    parser.consume(pose.bytes(), [&](const mavlink::FrameView&) { ++poses; });
  }
  EXPECT_EQ(poses, 10);
}

TEST_F(OrderLineTest, ALineThatIsGoneIsGoneHereToo) {
  pair.set_plugged(false);
  std::array<std::byte, 4> destination;
  EXPECT_EQ(line.read(destination).status(), core::Status::kUnavailable);
}

}  // namespace
}  // namespace m100::app
