// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/image/order_line.h"

#include <gtest/gtest.h>

#include <vector>

#include "hal/mock/manual_clock.h"
#include "hal/mock/uart_pair.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::app {
namespace {

// Would catch: a board that flies off because it was switched on, or started again by its watchdog, with the switch on.
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
  OrderLine<hal::Uart> line{pair.a()};

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
  EXPECT_EQ(pass(stream), stream);
  EXPECT_EQ(line.take(), Order::kEngage) << "the last movement counts";
  EXPECT_EQ(line.take(), Order::kNone) << "and counts once";
}

// The message is short, so each of its bits is tried.
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
