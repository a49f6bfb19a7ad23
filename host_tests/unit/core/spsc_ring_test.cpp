// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/spsc_ring.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <random>
#include <span>

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

// Catches a second piece that is read from the wrong place, and one element more than the ring holds. The indices wrap
// many times, so that the wrap occurs at every place for every length.
TEST(SpscRing, AgreesWithAPlainQueueWhereManyArePoppedAtOnce) {
  SpscRing<int, 8> ring;
  EXPECT_EQ(ring.capacity(), 8U);
  std::deque<int> queue;
  std::mt19937 random(11);
  std::array<int, 10> room{};
  for (int step = 0; step < 20000; ++step) {
    for (auto pushes = random() % 9; pushes > 0 && ring.push(step); --pushes) {
      queue.push_back(step);
    }
    const std::size_t fits = random() % (room.size() + 1);
    const std::span<int> popped = ring.pop_into(std::span(room).first(fits));
    ASSERT_EQ(popped.size(), std::min(fits, queue.size()));
    ASSERT_TRUE(std::equal(popped.begin(), popped.end(), queue.begin()));
    queue.erase(queue.begin(), queue.begin() + static_cast<std::ptrdiff_t>(popped.size()));
    ASSERT_EQ(ring.size(), queue.size());
  }
}

}  // namespace
}  // namespace m100::core
