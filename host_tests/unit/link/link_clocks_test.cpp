// SPDX-License-Identifier: BSD-3-Clause
// Time measurements of the link: its health figures, the autopilot's clock, the comparison with the pose source's
// clock.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "firmware/link/link_meter.h"
#include "firmware/link/pose/clock_comparison.h"
#include "firmware/link/telemetry/telemetry_check.h"
#include "firmware/link/telemetry/telemetry_clock.h"
#include "firmware/link/telemetry/telemetry_receiver.h"

namespace m100::link {
namespace {

using core::Duration;
using core::TimePoint;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

TimePoint at(Duration since) { return TimePoint{since}; }

TEST(LinkMeter, BeginsWithNothing) {
  LinkMeter meter(230400);
  meter.tick(at(milliseconds(10)));
  const LinkHealth& health = meter.health();
  EXPECT_EQ(health.telemetry_rate_hz + health.receive_share + health.send_share, 0.0);
  EXPECT_EQ(health.telemetry_age, Duration{0}) << "no package is not an old one";
  EXPECT_EQ(health.longest_gap + health.transport_delay, Duration{0});
  EXPECT_EQ(health.bytes_received + health.bytes_sent, 0U);
  EXPECT_EQ(health.packages + health.bad_packages + health.old_packages + health.refused_items + health.undecipherable +
                health.commands_sent + health.commands_refused + health.commands_dropped + health.outages +
                health.restarts + health.echoes,
            0U);
  EXPECT_EQ(meter.adapter_delay(), milliseconds(40)) << "nothing is known of the adapter: the longest";
}

// Rates and shares refer to the last full second; the line carries 23040 bytes per second.
TEST(LinkMeter, CountsBySeconds) {
  LinkMeter meter(230400);
  for (int tick = 1; tick <= 100; ++tick) {
    meter.received(100);
    meter.sent(20);
    if (tick % 2 == 0) {
      meter.package(at(milliseconds(10) * tick));
    }
    meter.tick(at(milliseconds(10) * tick));
    if (tick == 99) {
      EXPECT_EQ(meter.health().telemetry_rate_hz, 0.0) << "the second is not full";
    }
  }
  EXPECT_NEAR(meter.health().telemetry_rate_hz, 50.0, 1e-9);
  EXPECT_NEAR(meter.health().receive_share, 10000.0 / 23040.0, 1e-9);
  EXPECT_NEAR(meter.health().send_share, 2000.0 / 23040.0, 1e-9);
  EXPECT_EQ(meter.health().bytes_received, 10000U);
  EXPECT_EQ(meter.health().bytes_sent, 2000U);
  EXPECT_EQ(meter.health().packages, 50U);
  EXPECT_EQ(meter.health().longest_gap, milliseconds(20));
  meter.tick(at(milliseconds(1500)));
  EXPECT_EQ(meter.health().telemetry_age, milliseconds(500));
  EXPECT_NEAR(meter.health().telemetry_rate_hz, 50.0, 1e-9) << "until the next second is full";
  meter.package(at(milliseconds(1600)));
  meter.tick(at(milliseconds(2000)));
  EXPECT_NEAR(meter.health().telemetry_rate_hz, 1.0, 1e-9);
  EXPECT_EQ(meter.health().receive_share + meter.health().send_share, 0.0);
  EXPECT_EQ(meter.health().longest_gap, milliseconds(600));
}

// Packages earlier or later than the autopilot's clock says are sorted into bins by size; the upper end of a bin
// belongs to the next one.
TEST(LinkMeter, SortsJitterByItsSize) {
  const std::pair<std::int64_t, std::size_t> cases[] = {{0, 0},     {499, 0},    {500, 1},   {-500, 1},  {1000, 2},
                                                        {2000, 3},  {4000, 4},   {8000, 5},  {16000, 6}, {32000, 7},
                                                        {64000, 8}, {127999, 8}, {128000, 9}};
  for (const auto& [jitter_us, bin] : cases) {
    LinkMeter meter(230400);
    meter.timed_package(at(seconds(1)), milliseconds(300));
    meter.timed_package(at(seconds(1) + milliseconds(200) + microseconds(jitter_us)), milliseconds(500));
    for (std::size_t i = 0; i < meter.health().jitter_histogram.size(); ++i) {
      EXPECT_EQ(meter.health().jitter_histogram[i], i == bin ? 1U : 0U) << jitter_us << " us, bin " << i;
    }
  }
}

TEST(LinkMeter, TheDelayIsWhatAPackageCameLaterThanTheFastest) {
  LinkMeter meter(230400);
  meter.timed_package(at(milliseconds(1000)), milliseconds(300));
  EXPECT_EQ(meter.health().transport_delay, Duration{0});
  EXPECT_EQ(meter.adapter_delay(), milliseconds(2)) << "at least a UART's";
  meter.timed_package(at(milliseconds(1030)), milliseconds(320));
  EXPECT_EQ(meter.health().transport_delay, milliseconds(10) - microseconds(3)) << "less 100 ppm of 30 ms for drift";
  EXPECT_EQ(meter.adapter_delay(), milliseconds(10) - microseconds(3));
  meter.timed_package(at(milliseconds(1039)), milliseconds(340));  // faster than the fastest
  EXPECT_EQ(meter.health().transport_delay, Duration{0});
  EXPECT_EQ(meter.adapter_delay(), milliseconds(10) - microseconds(3)) << "the longest of this second";
  meter.tick(at(milliseconds(1100)));
  EXPECT_EQ(meter.adapter_delay(), milliseconds(10) - microseconds(3)) << "and of the one before";
  meter.tick(at(milliseconds(2100)));
  EXPECT_EQ(meter.adapter_delay(), milliseconds(2));
  meter.timed_package(at(milliseconds(3000)), milliseconds(2100));
  EXPECT_EQ(meter.adapter_delay(), milliseconds(40)) << "no adapter holds back for 200 ms";
  meter.restart();
  EXPECT_EQ(meter.adapter_delay(), milliseconds(40));
  EXPECT_EQ(meter.health().restarts, 1U);
  meter.timed_package(at(milliseconds(3100)), milliseconds(5));
  EXPECT_EQ(meter.health().transport_delay, Duration{0}) << "the new clock's first";
}

TelemetryClock::Verdict noted(TelemetryClock& clock, std::uint32_t ticks, Duration when) {
  return clock.update(ticks, at(when), at(when));
}

TEST(TelemetryClock, TakesEachTickOnceAndOnlyForwards) {
  TelemetryClock clock;
  EXPECT_TRUE(noted(clock, 1000, seconds(10)).is_new);
  EXPECT_FALSE(noted(clock, 1000, seconds(10) + milliseconds(10)).is_new) << "repeated";
  EXPECT_FALSE(noted(clock, 999, seconds(10) + milliseconds(10)).is_new) << "overtaken";
  EXPECT_TRUE(noted(clock, 1001, seconds(10) + milliseconds(10)).is_new);
  clock.reset();
  EXPECT_TRUE(noted(clock, 5, seconds(11)).is_new) << "the first of a clock that nobody knows";
  for (int later_ms = 0; later_ms < 20000; later_ms += 10) {
    const auto said = clock.update(5, at(seconds(11)), at(seconds(11) + milliseconds(later_ms)));
    ASSERT_FALSE(said.is_new || said.restarted) << "frozen for ever";
  }
  clock.reset();
  ASSERT_TRUE(noted(clock, 0xFFFFFFFEU, seconds(40)).is_new);
  EXPECT_TRUE(noted(clock, 2, seconds(40) + milliseconds(10)).is_new) << "its counter wraps";
}

// A clock step is measured with our clock: a step of one second is accepted, one tick more is a restart.
TEST(TelemetryClock, AStepOfMoreThanASecondIsARestart) {
  for (const int direction : {1, -1}) {
    for (const int ticks : {400, 401}) {
      TelemetryClock clock;
      ASSERT_TRUE(noted(clock, 100000, seconds(10)).is_new);
      const auto stepped = static_cast<std::uint32_t>(100000 + direction * ticks);
      EXPECT_EQ(noted(clock, stepped, seconds(10)).restarted, ticks == 401) << direction * ticks;
    }
  }
  TelemetryClock stands;
  ASSERT_TRUE(noted(stands, 1000, seconds(10)).is_new);
  EXPECT_TRUE(noted(stands, 1400, seconds(12)).is_new) << "a second behind is none";
  EXPECT_TRUE(noted(stands, 1401, seconds(14)).restarted);
}

TEST(TelemetryClock, ANewClockCountsFromItsSecondPackage) {
  for (const std::uint32_t first : {50000U, 200000U}) {
    TelemetryClock clock;
    ASSERT_TRUE(noted(clock, 100000, seconds(10)).is_new);
    const auto said = noted(clock, first, seconds(10));
    EXPECT_TRUE(said.restarted && !said.is_new) << first;
    const auto again = noted(clock, first, seconds(10) + milliseconds(10));
    EXPECT_FALSE(again.restarted || again.is_new) << "it has not advanced";
    const auto second = noted(clock, first + 4, seconds(10) + milliseconds(10));
    EXPECT_TRUE(second.is_new && !second.restarted) << first;
    EXPECT_TRUE(noted(clock, first - 397, seconds(10) + milliseconds(10)).restarted) << "by the last, not by the first";
    EXPECT_TRUE(noted(clock, first + 8, seconds(10) + milliseconds(20)).is_new) << first;
  }
}

TEST(TelemetryClock, AnOldPackageInBetweenIsNoNewClock) {
  TelemetryClock clock;
  ASSERT_TRUE(noted(clock, 100000, seconds(10)).is_new);
  ASSERT_TRUE(noted(clock, 50, seconds(10)).restarted);
  EXPECT_TRUE(noted(clock, 100004, seconds(10) + milliseconds(10)).is_new) << "the clock goes on";
  EXPECT_FALSE(noted(clock, 54, seconds(10) + milliseconds(20)).is_new) << "what jumped is forgotten";
}

TEST(ClockComparison, KnowsTheOffsetToHalfOfThereAndBack) {
  ClockComparison clocks;
  EXPECT_FALSE(clocks.offset(at(seconds(1))).known);
  EXPECT_EQ(clocks.offset(at(seconds(1))).bound, Duration{0});
  EXPECT_TRUE(clocks.due(at(seconds(1))));
  const std::int64_t control_requested = clocks.request(at(seconds(1)));
  EXPECT_EQ(control_requested, 1000000000);
  EXPECT_FALSE(clocks.due(at(milliseconds(1199))));
  EXPECT_TRUE(clocks.due(at(milliseconds(1200))));
  EXPECT_FALSE(clocks.answer(control_requested + 1, 5000000000, at(milliseconds(1020)))) << "to another question";
  EXPECT_TRUE(clocks.answer(control_requested, 5000000000, at(milliseconds(1020))));
  EXPECT_FALSE(clocks.answer(control_requested, 5000000000, at(milliseconds(1020)))) << "doubled";
  const core::ClockOffset offset = clocks.offset(at(milliseconds(1020)));
  EXPECT_TRUE(offset.known);
  EXPECT_EQ(offset.to_ours, milliseconds(1010) - seconds(5));
  EXPECT_EQ(offset.bound, milliseconds(10));
  EXPECT_EQ(clocks.offset(at(milliseconds(3020))).bound, milliseconds(12)) << "a thousandth of the time since";
}

TEST(ClockComparison, PassesLateAnswersOver) {
  for (const Duration took : {milliseconds(500), milliseconds(501)}) {
    ClockComparison clocks;
    const std::int64_t control_requested = clocks.request(at(seconds(1)));
    EXPECT_EQ(clocks.answer(control_requested, 0, at(seconds(1) + took)), took == milliseconds(500)) << took.count();
  }
  ClockComparison clocks;
  const std::int64_t control_requested = clocks.request(at(seconds(1)));
  EXPECT_FALSE(clocks.answer(control_requested, 0, at(milliseconds(999)))) << "before it was asked";
}

TEST(ClockComparison, KeepsTheBestAnswerUntilDriftMakesANewerOneBetter) {
  ClockComparison clocks;
  const auto compare = [&](Duration when, Duration took, Duration theirs) {
    const std::int64_t control_requested = clocks.request(at(when));
    return clocks.answer(control_requested, std::chrono::nanoseconds(theirs).count(), at(when + took));
  };
  ASSERT_TRUE(compare(seconds(1), milliseconds(4), seconds(1) + milliseconds(2)));
  EXPECT_EQ(clocks.offset(at(seconds(1))).to_ours, Duration{0});
  ASSERT_TRUE(compare(seconds(2), milliseconds(10), seconds(2) + milliseconds(3)));
  EXPECT_EQ(clocks.offset(at(seconds(2))).to_ours, Duration{0}) << "a worse answer changes nothing";
  ASSERT_TRUE(compare(seconds(6), milliseconds(10), seconds(6) + milliseconds(3)));
  EXPECT_EQ(clocks.offset(at(seconds(6))).to_ours, milliseconds(2)) << "the old one is worth 7 ms by now";
  ASSERT_TRUE(compare(seconds(7), milliseconds(40), seconds(90)));
  EXPECT_EQ(clocks.offset(at(seconds(7))).to_ours, milliseconds(7020) - seconds(90)) << "their clock was set";
  clocks.reset();
  EXPECT_FALSE(clocks.offset(at(seconds(8))).known);
  EXPECT_TRUE(clocks.due(at(milliseconds(7001))));
}

struct TelemetryReceiverTest : ::testing::Test {
  LinkMeter meter{230400};
  TelemetryReceiver receiver;
  using Item = protocol::TelemetryItem;

  TelemetryReceiver::Reception take(std::uint32_t ticks, float roll, std::uint16_t items, Duration when,
                                    bool waited = false) {
    protocol::Telemetry package;
    package.items = static_cast<std::uint16_t>(items | static_cast<std::uint16_t>(Item::kTime));
    package.time.ticks = ticks;
    package.attitude = {1.F, roll, 0.F, 0.F};
    return receiver.take(protocol::encode(package).bytes(), waited, at(when - milliseconds(10)), at(when), meter);
  }
};

TEST_F(TelemetryReceiverTest, AnOldPackageChangesNothing) {
  constexpr auto kAttitude = static_cast<std::uint16_t>(Item::kAttitude), kRc = static_cast<std::uint16_t>(Item::kRc);
  EXPECT_FALSE(receiver.recent(Item::kAttitude, at(Duration{0}), seconds(1))) << "it never came";
  EXPECT_EQ(take(1000, 0.1F, kAttitude, seconds(1)).items, kAttitude | 1);
  EXPECT_EQ(take(1004, 0.9F, kRc, seconds(2)).items, kRc | 1);
  EXPECT_EQ(receiver.telemetry().items, kAttitude | kRc | 1) << "all of this tick";
  receiver.begin();
  EXPECT_EQ(receiver.telemetry().items, 0);
  EXPECT_TRUE(take(1002, 0.2F, kAttitude, seconds(3)).is_old);
  EXPECT_EQ(receiver.telemetry().attitude[1], 0.1F);
  EXPECT_EQ(receiver.telemetry().items, 0);
  EXPECT_EQ(meter.health().old_packages, 1U);
  EXPECT_TRUE(take(1005, 0.1F, 0, seconds(3), true).items != 0);
  EXPECT_EQ(meter.health().jitter_histogram[9], 1U) << "one that is old, or waited, shows no jitter";
  EXPECT_EQ(receiver.received_at(Item::kAttitude), at(seconds(1)));
  EXPECT_EQ(receiver.received_at(Item::kRc), at(seconds(2)));
  EXPECT_TRUE(receiver.recent(Item::kAttitude, at(seconds(3)), seconds(2)));
  EXPECT_FALSE(receiver.recent(Item::kAttitude, at(seconds(3)), seconds(2) - Duration{1}));
  EXPECT_TRUE(take(9, 0.2F, kAttitude, seconds(3)).restarted);
  EXPECT_EQ(meter.health().restarts, 1U);
  receiver.set_layout(protocol::TelemetryLayout::kFamily);
  receiver.reset();
  EXPECT_EQ(receiver.layout(), protocol::TelemetryLayout::kM100);
  EXPECT_FALSE(receiver.recent(Item::kRc, at(seconds(3)), seconds(9)));
  EXPECT_FALSE(take(5, 0.3F, kAttitude, seconds(3)).is_old) << "of another autopilot";
}

// Would catch an item that is refused because of another item's value, or that is replaced although no earlier value
// exists.
TEST(KeepFinite, RefusesTheItemThatHoldsSuchANumberAndNoOther) {
  using Item = protocol::TelemetryItem;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  struct Case {
    Item item;
    void (*spoil)(protocol::Telemetry&, float);
  };
  const Case cases[] = {
      {Item::kAttitude, [](protocol::Telemetry& t, float bad) { t.attitude[3] = bad; }},
      {Item::kAcceleration, [](protocol::Telemetry& t, float bad) { t.acceleration[2] = bad; }},
      {Item::kVelocity, [](protocol::Telemetry& t, float bad) { t.velocity_ned_m_s[0] = bad; }},
      {Item::kAngularVelocity, [](protocol::Telemetry& t, float bad) { t.angular_velocity_frd_rad_s[1] = bad; }},
      {Item::kPosition, [](protocol::Telemetry& t, float bad) { t.position.latitude_rad = static_cast<double>(bad); }},
      {Item::kPosition, [](protocol::Telemetry& t, float bad) { t.position.longitude_rad = static_cast<double>(bad); }},
      {Item::kPosition, [](protocol::Telemetry& t, float bad) { t.position.altitude_m = bad; }},
      {Item::kPosition, [](protocol::Telemetry& t, float bad) { t.position.height_m = bad; }}};
  for (const Case& one : cases) {
    for (const float bad : {nan, std::numeric_limits<float>::infinity()}) {
      protocol::Telemetry former, now;
      former.attitude = {0.F, 1.F, 0.F, 0.F};
      former.acceleration = former.velocity_ned_m_s = former.angular_velocity_frd_rad_s = {7.F, 8.F, 9.F};
      former.position.height_m = 5.F;
      now.items = protocol::kAllTelemetryItems;
      now.acceleration = now.velocity_ned_m_s = now.angular_velocity_frd_rad_s = {1.F, 2.F, 3.F};
      now.position.height_m = 2.F;
      one.spoil(now, bad);
      EXPECT_EQ(reject_non_finite(now, former), 1U);
      EXPECT_EQ(now.items, protocol::kAllTelemetryItems & ~static_cast<unsigned>(one.item));
      EXPECT_EQ(now.attitude[1], one.item == Item::kAttitude ? 1.F : 0.F);
      EXPECT_EQ(now.acceleration[2], one.item == Item::kAcceleration ? 9.F : 3.F);
      EXPECT_EQ(now.velocity_ned_m_s[0], one.item == Item::kVelocity ? 7.F : 1.F);
      EXPECT_EQ(now.angular_velocity_frd_rad_s[1], one.item == Item::kAngularVelocity ? 8.F : 2.F);
      EXPECT_EQ(now.position.height_m, one.item == Item::kPosition ? 5.F : 2.F);
      EXPECT_TRUE(std::isfinite(now.position.latitude_rad));
    }
  }
  protocol::Telemetry silent;
  silent.attitude[0] = nan;
  silent.items = static_cast<std::uint16_t>(Item::kTime);
  EXPECT_EQ(reject_non_finite(silent, {}), 0U) << "an item that did not come is not judged";
}

}  // namespace
}  // namespace m100::link
