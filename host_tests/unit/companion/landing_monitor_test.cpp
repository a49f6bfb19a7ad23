// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/monitor/landing_monitor.h"

#include <gtest/gtest.h>

namespace m100::companion {
namespace {

using protocol::FlightStatus;

core::TimePoint at(int ms) { return core::TimePoint(std::chrono::milliseconds(ms)); }

TEST(LandingMonitor, HalfASecondOfItemsThatSaySoIsALanding) {
  LandingMonitor monitor;
  monitor.update(FlightStatus::kInAir, at(0));
  for (int ms = 100; ms <= 500; ms += 100) {
    monitor.update(FlightStatus::kLanding, at(ms));
    EXPECT_FALSE(monitor.lands()) << ms;
  }
  monitor.update(FlightStatus::kLanding, at(600));
  EXPECT_TRUE(monitor.lands());
  monitor.update(FlightStatus::kInAir, at(700));
  EXPECT_FALSE(monitor.lands());
}

// Catches a monitor that counts from the last item with another status: one item after a gap was a landing.
TEST(LandingMonitor, OneItemAfterAGapOfTelemetryIsNone) {
  LandingMonitor monitor;
  monitor.update(FlightStatus::kInAir, at(0));
  monitor.update(FlightStatus::kLanding, at(900));
  for (int tick = 0; tick < 100; ++tick) {
    monitor.update(FlightStatus::kLanding, at(900));  // no new item
  }
  EXPECT_FALSE(monitor.lands());
}

}  // namespace
}  // namespace m100::companion
