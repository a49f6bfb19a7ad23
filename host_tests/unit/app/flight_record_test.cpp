// SPDX-License-Identifier: BSD-3-Clause
// The record of a tick, read back from the log.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <vector>

#include "firmware/app/flight_controller.h"
#include "firmware/log/flight_log.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/golden/flight/flight_recording.h"

namespace m100::app {
namespace {

/// A flight program on two silent lines, with a log that nobody reads unless the test does.
struct FlightRecordTest : ::testing::Test {
  std::array<std::byte, 4096> storage{};
  log::Ring ring{storage};
  log::FlightLogWriter log{ring};
  golden::ReplayedUart autopilot;
  golden::ReplayedUart pose;
  ref::Trajectory<double> course;
  mpc::GainTables<double> tables{mpc::generated::kX<double>, mpc::generated::kY<double>};
  FlightController<double> controller{mpc::generated::kVehicle, tables, kDefaultFlight, autopilot, pose, course, &log};
  core::TimePoint now{std::chrono::seconds(7)};

  void tick(core::Duration after = core::kTickPeriod) {
    EXPECT_EQ(controller.tick(now += after), core::Status::kRefused) << "silent by the failsafe";
  }
  std::vector<std::byte> drain() {
    std::vector<std::byte> bytes;
    ring.drain([&bytes](std::span<const std::byte> piece) { bytes.insert(bytes.end(), piece.begin(), piece.end()); });
    return bytes;
  }
  /// The record of one more tick: it is the last that the tick writes.
  log::TickRecord record_of_tick(core::Duration after = core::kTickPeriod) {
    (void)drain();
    tick(after);
    const std::vector<std::byte> bytes = drain();
    log::TickRecord record;
    EXPECT_GE(bytes.size(), sizeof(record));
    std::memcpy(&record, bytes.data() + bytes.size() - sizeof(record), sizeof(record));
    return record;
  }
};

// Catches a count that is zero whatever the log has lost.
TEST_F(FlightRecordTest, HoldsWhatItsLogHasLostUntilThen) {
  EXPECT_EQ(record_of_tick().dropped_messages, 0U);
  for (int unread = 0; unread < 100; ++unread) {
    tick();
  }
  const std::uint32_t lost = log.dropped();
  ASSERT_GT(lost, 10U);
  EXPECT_EQ(record_of_tick().dropped_messages, lost);
}

TEST_F(FlightRecordTest, HoldsItsTimeAndHowLateItCame) {
  tick();
  const log::TickRecord in_time = record_of_tick();
  EXPECT_EQ(in_time.timestamp, static_cast<std::uint64_t>(now.time_since_epoch().count()));
  EXPECT_EQ(in_time.late, 0.F);
  EXPECT_NEAR(record_of_tick(std::chrono::milliseconds(37)).late, 0.027F, 1e-6F);
}

TEST_F(FlightRecordTest, WithoutALogNothingIsRecorded) {
  FlightController<double> unlogged{mpc::generated::kVehicle, tables, kDefaultFlight, autopilot, pose, course, nullptr};
  EXPECT_EQ(unlogged.tick(now), core::Status::kRefused);
}

// A stall is longer than two periods; the first tick covers one.
TEST(TickTimerTest, CountsTicksStallsAndTheLongest) {
  TickTimer timer;
  core::TimePoint now{std::chrono::seconds(7)};
  std::uint32_t ticks = 0, stalls = 0;
  for (const int after_us : {900000, 10000, 20000, 20001, 9000}) {
    timer.update(now += std::chrono::microseconds(after_us));
    stalls += after_us == 20001 ? 1U : 0U;
    EXPECT_EQ(timer.elapsed(), std::chrono::microseconds(ticks == 0 ? 10000 : after_us));
    EXPECT_EQ(timer.is_stall(), after_us == 20001);
    EXPECT_EQ(timer.last(), now);
    EXPECT_EQ(timer.stats().ticks, ++ticks);
    EXPECT_EQ(timer.stats().stalls, stalls);
  }
  EXPECT_EQ(timer.stats().longest, std::chrono::microseconds(20001));
}

}  // namespace
}  // namespace m100::app
