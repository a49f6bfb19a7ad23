// SPDX-License-Identifier: BSD-3-Clause
// The statistics of `m100 record`: a stream that stops for good has a gap too, and a rate is measured with the
// autopilot's clock.
#include "firmware/companion/record/recorder.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "protocol/dji/frame_encoder.h"
#include "protocol/dji/session.h"

namespace m100::companion {
namespace {

using std::chrono::milliseconds;

core::TimePoint at(int time_ms) { return core::TimePoint{} + milliseconds(time_ms); }

Recorder::StreamStatistics hundred_hertz_until(int end_ms) {
  Recorder::StreamStatistics statistics;
  for (int time_ms = 0; time_ms <= end_ms; time_ms += 10) {
    statistics.add(at(time_ms));
  }
  return statistics;
}

TEST(RecorderTest, AStreamThatStopsBeforeTheEndHasAGap) {
  Recorder::StreamStatistics statistics = hundred_hertz_until(1000);
  statistics.end(at(6000));
  EXPECT_EQ(statistics.gaps, 1U);
  EXPECT_EQ(statistics.longest_gap, milliseconds(5000));
  EXPECT_EQ(statistics.samples, 101U) << "the end is no sample";
}

TEST(RecorderTest, AStreamThatComesUntilTheEndHasNone) {
  Recorder::StreamStatistics statistics = hundred_hertz_until(1000);
  statistics.end(at(1012));
  EXPECT_EQ(statistics.gaps, 0U);
  EXPECT_EQ(statistics.longest_gap, milliseconds(12));
}

// A gap is longer than 50 ms and longer than three and a half intervals: 70 ms for an interval of 20 ms.
TEST(RecorderTest, AGapIsLongerThanBothItsBounds) {
  Recorder::StreamStatistics fast = hundred_hertz_until(1000);
  fast.end(at(1050));
  EXPECT_EQ(fast.gaps, 0U) << "50 ms are none";
  fast = hundred_hertz_until(1000);
  fast.end(at(1051));
  EXPECT_EQ(fast.gaps, 1U);
  for (const auto& [end_ms, gaps] : {std::pair{1069, 0U}, std::pair{1071, 1U}}) {
    Recorder::StreamStatistics slow;
    for (int time_ms = 0; time_ms <= 1000; time_ms += 20) {
      slow.add(at(time_ms));
    }
    slow.end(at(end_ms));
    EXPECT_EQ(slow.gaps, gaps) << end_ms;
  }
}

TEST(RecorderTest, NobodyKnowsTheIntervalOfNineSamples) {
  for (const int samples : {9, 10}) {
    Recorder::StreamStatistics statistics = hundred_hertz_until(10 * (samples - 1));
    statistics.end(at(5000));
    EXPECT_EQ(statistics.gaps, samples == 9 ? 0U : 1U);
  }
}

/// A telemetry package with the autopilot's time stamp `made_ms`; its clock counts ticks of 2.5 ms.
void take_package(Recorder& recorder, int made_ms, core::TimePoint arrived) {
  protocol::Telemetry telemetry;
  telemetry.items = protocol::kAllTelemetryItems;
  telemetry.time.ticks = static_cast<std::uint32_t>(made_ms * 2 / 5);
  std::array<std::byte, 256> space;
  const core::Expected<std::span<const std::byte>> frame = protocol::encode_frame(
      {.session = protocol::kUnansweredSession, .is_ack = false, .encrypted = false, .sequence = 1},
      &protocol::ids::kTelemetry, encode(telemetry), space);
  ASSERT_TRUE(frame);
  recorder.take(*frame, arrived);
}

// A delayed program reads several packages at once, up to 400 ms late: a rate by our own clock would show gaps and
// bursts that the autopilot never made.
TEST(RecorderTest, ARateIsByTheAutopilotsClockHoweverLateAPackageIsRead) {
  std::vector<std::byte> storage(1U << 20U);
  log::Ring ring(storage);
  log::UlogWriter log(ring);
  Recorder recorder(log, 230400, nullptr);
  ASSERT_EQ(recorder.begin(at(0), {}), core::Status::kOk);
  constexpr int kInterval_ms = 20, kWait_ms = 400, kPackages = 100;
  for (int package = 0; package < kPackages; ++package) {
    const int made_ms = kInterval_ms * package;
    const bool is_read_late = (made_ms / kWait_ms) % 2 == 1;
    take_package(recorder, made_ms, at(is_read_late ? (made_ms / kWait_ms + 1) * kWait_ms : made_ms));
  }
  const Recorder::StreamStatistics& statistics = recorder.statistics(Recorder::kAttitude);
  EXPECT_EQ(statistics.samples, kPackages);
  EXPECT_NEAR(statistics.rate_hz(), 1000.0 / kInterval_ms, 0.02) << "200 ppm of drift are allowed, and twice that held";
  EXPECT_EQ(statistics.gaps, 0U);
  EXPECT_EQ(recorder.restarts(), 0U);
}

TEST(RecorderTest, AStreamThatNeverCameHasNoGap) {
  Recorder::StreamStatistics statistics;
  statistics.end(at(6000));
  EXPECT_EQ(statistics.gaps, 0U);
}

}  // namespace
}  // namespace m100::companion
