// SPDX-License-Identifier: BSD-3-Clause
// The faults of the mock line, one by one: their effect, their counts, and what they leave unchanged.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "host_tests/unit/hal/line_bytes.h"

namespace m100::hal {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

struct UartFaults : ::testing::Test {
  ManualClock clock;
  UartPair pair{clock, 230400};
};

// A line without faults only delays the bytes, and counts only bytes.
TEST_F(UartFaults, AnUntouchedLineIsWholeAndCountsBytesOnly) {
  const auto sum = [&] {
    const Line::Stats& s = pair.a_to_b().stats();
    return s.bytes_dropped + s.bits_flipped + s.bytes_added + s.overruns + s.writes_dropped;
  };
  EXPECT_EQ(sum() + pair.a_to_b().stats().bytes_written + pair.a_to_b().stats().bytes_read, 0U);
  ASSERT_EQ(pair.a().write(counting(256)).value(), 256U);
  clock.advance(milliseconds(100));
  EXPECT_EQ(read_all(pair.b()), counting(256));
  EXPECT_EQ(sum(), 0U);
  EXPECT_EQ(pair.a_to_b().stats().bytes_written, 256U);
  EXPECT_EQ(pair.a_to_b().stats().bytes_read, 256U);
  EXPECT_EQ(pair.b().line_errors().value(), LineErrors{});
}

TEST_F(UartFaults, EachFaultDoesWhatItsNameSaysAndIsCounted) {
  const auto send = [&](const LineFaults& faults) {
    pair.a_to_b().set_faults(faults);
    (void)pair.a().write(counting(5));
    clock.advance(milliseconds(100));
    return read_all(pair.b());
  };
  const Line::Stats& stats = pair.a_to_b().stats();
  EXPECT_TRUE(send({.drop_per_byte = 1.0}).empty());
  EXPECT_EQ(stats.bytes_dropped, 5U);
  EXPECT_TRUE(send({.drop_per_write = 1.0}).empty());
  EXPECT_EQ(stats.bytes_dropped, 10U);
  EXPECT_EQ(stats.writes_dropped, 1U);
  std::vector<std::byte> inverted = counting(5);
  std::transform(inverted.begin(), inverted.end(), inverted.begin(), [](std::byte b) { return ~b; });
  EXPECT_EQ(send({.flip_per_bit = 1.0}), inverted);
  EXPECT_EQ(stats.bits_flipped, 40U);
  std::size_t added = 0;
  for (const auto& [faults, more] : {std::pair{LineFaults{.duplicate_per_byte = 1.0}, 5U},
                                     {LineFaults{.duplicate_per_write = 1.0}, 5U},
                                     {LineFaults{.break_per_write = 1.0}, 1U},
                                     {LineFaults{.burst_per_write = 1.0, .burst_bytes = 7}, 7U}}) {
    EXPECT_EQ(send(faults).size(), 5U + more);
    EXPECT_EQ(stats.bytes_added, added += more);
  }
  EXPECT_EQ(stats.bytes_written, 35U);
  EXPECT_EQ(stats.overruns, 0U);
  EXPECT_EQ(send({.longest_write = 3}).size(), 3U);
  EXPECT_TRUE(send({.delay = milliseconds(200)}).empty());
  clock.advance(milliseconds(200));
  EXPECT_EQ(read_all(pair.b()).size(), 5U);
}

// Noise with only half of the byte values would miss half of a parser's faults.
TEST_F(UartFaults, NoiseHasEveryValue) {
  const auto values_of = [&](const LineFaults& faults, std::size_t size) {
    pair.a_to_b().set_faults(faults);
    (void)pair.a().write(std::vector<std::byte>(size));
    clock.advance(milliseconds(500));
    std::vector<std::byte> got = read_all(pair.b());
    std::sort(got.begin(), got.end());
    return std::unique(got.begin(), got.end()) - got.begin();
  };
  EXPECT_EQ(values_of({.burst_per_write = 1.0, .burst_bytes = 4000}, 1), 256);
  EXPECT_EQ(values_of({.framing_error_per_byte = 1.0}, 4000), 256);
}

TEST_F(UartFaults, ALostByteTakesItsTimeOnTheLineAllTheSame) {
  pair.a_to_b().set_faults({.drop_per_byte = 1.0});
  (void)pair.a().write(counting(9));
  pair.a_to_b().set_faults({});
  (void)pair.a().write(counting(1));
  clock.advance(microseconds(434));  // ten bytes of 43.4028 us each take longer
  EXPECT_TRUE(read_all(pair.b()).empty());
  clock.advance(microseconds(1));
  EXPECT_EQ(read_all(pair.b()).size(), 1U);
}

TEST_F(UartFaults, AnAdaptersTimerHandsOverAtItsMultiples) {
  pair.a_to_b().set_faults({.chunk = milliseconds(16)});
  (void)pair.a().write(counting(3));
  clock.advance(microseconds(15999));
  EXPECT_TRUE(read_all(pair.b()).empty());
  clock.advance(microseconds(1));
  EXPECT_EQ(read_all(pair.b()).size(), 3U);
  UartPair at_once{clock, 0};
  at_once.a_to_b().set_faults({.chunk = milliseconds(16)});
  (void)at_once.a().write(counting(1));
  EXPECT_EQ(read_all(at_once.b()).size(), 1U) << "what arrives at a multiple waits for no other";
}

TEST_F(UartFaults, AByteNeverOvertakesItsPredecessor) {
  pair.a_to_b().set_faults({.delay = milliseconds(20)});
  (void)pair.a().write(std::vector{std::byte{1}});
  pair.a_to_b().set_faults({});
  (void)pair.a().write(std::vector{std::byte{2}});
  clock.advance(milliseconds(20));
  EXPECT_TRUE(read_all(pair.b()).empty());
  clock.advance(milliseconds(1));
  EXPECT_EQ(read_all(pair.b()), (std::vector{std::byte{1}, std::byte{2}}));
}

// Only a fault can put more bytes on the line than the sender and the receiver may hold.
TEST_F(UartFaults, WhatFindsNoRoomOnTheLineIsLostAndCounted) {
  pair.a_to_b().set_faults({.duplicate_per_byte = 1.0, .burst_per_write = 1.0, .burst_bytes = 10});
  EXPECT_EQ(pair.a().write(counting(Line::kSenderBytes)).value(), Line::kSenderBytes);
  EXPECT_EQ(pair.a_to_b().stats().overruns, 10U);
  EXPECT_EQ(pair.b().line_errors().value().overrun, 10U);
}

}  // namespace
}  // namespace m100::hal
