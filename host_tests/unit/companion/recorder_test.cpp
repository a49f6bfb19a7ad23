// SPDX-License-Identifier: BSD-3-Clause
// What m100 record says of a stream: a gap is one also where it never ends.
#include "firmware/companion/record/recorder.h"

#include <gtest/gtest.h>

#include <utility>

namespace m100::companion {
namespace {

using std::chrono::milliseconds;

core::TimePoint at(int time_ms) { return core::TimePoint{} + milliseconds(time_ms); }

Recorder::Came hundred_hertz_until(int end_ms) {
  Recorder::Came came;
  for (int time_ms = 0; time_ms <= end_ms; time_ms += 10) {
    came.note(at(time_ms));
  }
  return came;
}

TEST(RecorderTest, AStreamThatStopsBeforeTheEndHasAGap) {
  Recorder::Came came = hundred_hertz_until(1000);
  came.end(at(6000));
  EXPECT_EQ(came.gaps, 1U);
  EXPECT_EQ(came.longest_gap, milliseconds(5000));
  EXPECT_EQ(came.samples, 101U) << "the end is no sample";
}

TEST(RecorderTest, AStreamThatComesUntilTheEndHasNone) {
  Recorder::Came came = hundred_hertz_until(1000);
  came.end(at(1012));
  EXPECT_EQ(came.gaps, 0U);
  EXPECT_EQ(came.longest_gap, milliseconds(12));
}

// A gap is longer than 50 ms, and than three and a half intervals: of 20 ms, 70.
TEST(RecorderTest, AGapIsLongerThanBothItsBounds) {
  Recorder::Came fast = hundred_hertz_until(1000);
  fast.end(at(1050));
  EXPECT_EQ(fast.gaps, 0U) << "50 ms are none";
  fast = hundred_hertz_until(1000);
  fast.end(at(1051));
  EXPECT_EQ(fast.gaps, 1U);
  for (const auto& [end_ms, gaps] : {std::pair{1069, 0U}, std::pair{1071, 1U}}) {
    Recorder::Came slow;
    for (int time_ms = 0; time_ms <= 1000; time_ms += 20) {
      slow.note(at(time_ms));
    }
    slow.end(at(end_ms));
    EXPECT_EQ(slow.gaps, gaps) << end_ms;
  }
}

TEST(RecorderTest, NobodyKnowsTheIntervalOfNineSamples) {
  for (const int samples : {9, 10}) {
    Recorder::Came came = hundred_hertz_until(10 * (samples - 1));
    came.end(at(5000));
    EXPECT_EQ(came.gaps, samples == 9 ? 0U : 1U);
  }
}

TEST(RecorderTest, AStreamThatNeverCameHasNoGap) {
  Recorder::Came came;
  came.end(at(6000));
  EXPECT_EQ(came.gaps, 0U);
}

}  // namespace
}  // namespace m100::companion
