// SPDX-License-Identifier: BSD-3-Clause
// What m100 record says of a stream: a gap is one also where it never ends.
#include "firmware/companion/record/recorder.h"

#include <gtest/gtest.h>

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

TEST(RecorderTest, AStreamThatNeverCameHasNoGap) {
  Recorder::Came came;
  came.end(at(6000));
  EXPECT_EQ(came.gaps, 0U);
}

}  // namespace
}  // namespace m100::companion
