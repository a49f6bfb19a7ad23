// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/tick_count.h"

#include <gtest/gtest.h>

#include <initializer_list>

namespace m100::core {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

int sum(std::initializer_list<Duration> pattern, int times, int most = 5) {
  TickCount count;
  int ticks = 0;
  for (int i = 0; i < times; ++i) {
    for (const Duration elapsed : pattern) {
      ticks += count.take(elapsed, most);
    }
  }
  return ticks;
}

// Catches a count that loses the remainder of each call and gives at least one tick: 17 and 3 ms were three ticks.
TEST(TickCount, AddsUpWhateverTheJitter) {
  EXPECT_EQ(sum({milliseconds(10)}, 100), 100);
  EXPECT_EQ(sum({milliseconds(17), milliseconds(3)}, 50), 100);
  EXPECT_EQ(sum({milliseconds(15), milliseconds(5)}, 50), 100);
  EXPECT_EQ(sum({milliseconds(14), milliseconds(6)}, 50), 100);
  EXPECT_EQ(sum({milliseconds(25), milliseconds(1), milliseconds(4)}, 50), 150);
  EXPECT_EQ(sum({milliseconds(0), milliseconds(20)}, 50), 100);
}

TEST(TickCount, HandsOutAStallOverTheNextCallsAndHalfASecondAtMost) {
  TickCount count;
  EXPECT_EQ(count.take(milliseconds(150), 5), 5);
  EXPECT_EQ(count.behind(), milliseconds(100));
  EXPECT_EQ(count.take(milliseconds(10), 5), 5);
  EXPECT_EQ(count.take(milliseconds(10), 5), 5);
  EXPECT_EQ(count.take(milliseconds(10), 5), 3);
  EXPECT_EQ(count.behind(), Duration(0));
  EXPECT_EQ(count.take(std::chrono::hours(1), 5), 5);
  EXPECT_EQ(count.behind(), milliseconds(450));
}

// Catches a count that stays halfway between two ticks and alternates between 0 and 2 ticks for ever.
TEST(TickCount, ComesToRestAfterTheLoopHasSetItsClockAnew) {
  TickCount count;
  count.take(microseconds(15'000), 5);
  for (int i = 0; i < 200; ++i) {
    const int ticks = count.take(microseconds(i % 2 == 0 ? 9'900 : 10'100), 5);
    EXPECT_TRUE(i < 10 || ticks == 1) << i;
  }
}

}  // namespace
}  // namespace m100::core
