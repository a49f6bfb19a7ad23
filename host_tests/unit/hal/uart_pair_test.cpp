// SPDX-License-Identifier: BSD-3-Clause
#include "hal/mock/uart_pair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "hal/mock/wrong_baud.h"
#include "host_tests/unit/hal/line_bytes.h"

namespace m100::hal {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

struct UartPairTest : ::testing::Test {
  ManualClock clock;
  UartPair pair{clock, 230400};
};

// Catches a mock that delivers at once, which would hide every problem of a slow line. Protocol, section 10: 6.16 ms.
TEST_F(UartPairTest, AFullTelemetryFrameTakesItsTimeOnTheLine) {
  ASSERT_EQ(pair.a().write(counting(142)).value(), 142U);
  clock.advance(microseconds(6163));
  EXPECT_EQ(read_all(pair.b()).size(), 141U);
  clock.advance(microseconds(1));
  EXPECT_EQ(read_all(pair.b()).size(), 1U);
}

TEST_F(UartPairTest, AReaderWhoSleepsTooLongLosesTheNewest) {
  for (int i = 0; i < 2; ++i) {
    ASSERT_EQ(pair.a().write(std::vector<std::byte>(4000, std::byte(i))).value(), 4000U);
    clock.advance(milliseconds(200));
  }
  const std::vector<std::byte> got = read_all(pair.b());
  ASSERT_EQ(got.size(), Line::kReceiverBytes);
  EXPECT_EQ(got.front(), std::byte{0});
  EXPECT_EQ(pair.a_to_b().stats().overruns, 8000 - Line::kReceiverBytes);
  EXPECT_EQ(pair.b().line_errors().value().overrun, 8000 - Line::kReceiverBytes);
}

TEST_F(UartPairTest, ScriptedLineErrorsDamageTheBytesAndAreCountedAtTheirEnd) {
  Line& line = pair.a_to_b();
  line.set_faults({.framing_error_per_byte = 1.0, .break_per_write = 1.0});
  ASSERT_EQ(pair.a().write(counting(200)).value(), 200U);
  clock.advance(milliseconds(100));
  const std::vector<std::byte> got = read_all(pair.b());
  ASSERT_EQ(got.size(), 201U) << "a break is received as a zero byte";
  EXPECT_EQ(got[0], std::byte{0});
  EXPECT_NE(std::vector<std::byte>(got.begin() + 1, got.end()), counting(200));
  line.set_faults({.parity_error_per_byte = 1.0});
  ASSERT_EQ(pair.a().write(counting(3)).value(), 3U);
  EXPECT_EQ(pair.b().line_errors().value(), (LineErrors{.framing = 200, .parity = 3, .overrun = 0, .breaks = 1}));
  EXPECT_EQ(pair.a().line_errors().value(), LineErrors{}) << "the other direction is whole";
}

TEST_F(UartPairTest, AnUnpluggedCableSaysSoAndForgetsWhatWasOnIt) {
  std::array<std::byte, 16> destination;
  for (const bool at_the_sender : {true, false}) {
    ASSERT_EQ(pair.a().write(counting(10)).value(), 10U);
    clock.advance(microseconds(200));  // some have arrived
    pair.set_plugged(false);
    EXPECT_EQ((at_the_sender ? pair.a().write(counting(1)) : pair.b().read(destination)).status(),
              core::Status::kUnavailable);
    pair.set_plugged(true);
    clock.advance(milliseconds(10));
    EXPECT_EQ(pair.b().read(destination).value(), 0U);
  }
}

TEST_F(UartPairTest, RandomLossIsOfTheAskedSizeAndTheSameForTheSameSeed) {
  const auto lost = [](std::uint64_t seed) {
    ManualClock own_clock;
    UartPair own{own_clock, 0, seed};
    own.a_to_b().set_faults({.drop_per_byte = 0.1});
    std::size_t received = 0;
    for (int i = 0; i < 1000; ++i) {
      (void)own.a().write(counting(100));
      received += read_all(own.b()).size();
    }
    return 100000 - received;
  };
  EXPECT_NEAR(static_cast<double>(lost(1)), 10000.0, 400.0);  // four standard deviations of the binomial: 4 * 95
  EXPECT_EQ(lost(7), lost(7));
  EXPECT_NE(lost(7), lost(8));
}

TEST(WrongBaud, TheRightRateChangesNothing) {
  const std::vector<std::byte> sent = counting(256);
  EXPECT_EQ(received_at(sent, 230400, 230400), sent);
  EXPECT_EQ(received_at(sent, 230400, 233000), sent) << "1 % off is within what a UART must take";
}

TEST(WrongBaud, AnotherRateLeavesNothingOfTheMessage) {
  const std::vector<std::byte> sent = counting(256);
  const std::vector<std::byte> got = received_at(sent, 230400, 115200);
  EXPECT_LT(got.size(), 150U);
  EXPECT_TRUE(std::search(got.begin(), got.end(), sent.begin() + 100, sent.begin() + 104) == got.end());
  EXPECT_GT(received_at(sent, 230400, 921600).size(), 256U);
}

TEST(ManualClockTest, SleepsMoveItForwardOnly) {
  ManualClock clock;
  clock.sleep_until(core::TimePoint{milliseconds(10)});
  EXPECT_EQ(clock.now(), core::TimePoint{milliseconds(10)});
  clock.sleep_until(core::TimePoint{milliseconds(5)});
  EXPECT_EQ(clock.now(), core::TimePoint{milliseconds(10)});
}

}  // namespace
}  // namespace m100::hal
