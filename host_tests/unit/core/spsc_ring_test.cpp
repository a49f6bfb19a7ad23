// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/spsc_ring.h"

#include <gtest/gtest.h>

#include <deque>
#include <random>

namespace m100::core {
namespace {

// Catches off-by-one capacity, lost wrap-around, and overwriting when full.
TEST(SpscRing, AgreesWithAPlainQueueUnderAnySequenceOfPushesAndPops) {
  SpscRing<int, 8> ring;
  std::deque<int> queue;
  std::mt19937 random(7);
  std::uint32_t refused = 0;
  for (int step = 0; step < 100000; ++step) {
    if (random() % 2 == 0) {
      const bool pushed = ring.push(step);
      ASSERT_EQ(pushed, queue.size() < 8);
      if (pushed) {
        queue.push_back(step);
      } else {
        ++refused;
      }
    } else {
      int value = -1;
      ASSERT_EQ(ring.pop(value), !queue.empty());
      if (!queue.empty()) {
        ASSERT_EQ(value, queue.front());
        queue.pop_front();
      }
    }
    ASSERT_EQ(ring.size(), queue.size());
  }
  EXPECT_EQ(ring.dropped(), refused);
}

}  // namespace
}  // namespace m100::core
