// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/flight_monitors.h"

#include <gtest/gtest.h>

#include "firmware/mpc/generated/gain_table.h"

namespace m100::app {
namespace {

/// Complete blocks of ten seconds at rest in which `missing` attitudes in a row are missing every 2.1 s.
std::uint32_t blocks(int missing) {
  const model::Vehicle& vehicle = mpc::generated::kVehicle;
  FlightMonitors<double> monitors(vehicle, ctl::braking_of(vehicle, 0.2), core::kTickPeriod, false);
  const vrc::Sticks sticks{vrc::kStickCentre, vrc::kStickCentre, vrc::kStickCentre, vrc::kStickCentre};
  for (int tick = 0; tick < 1000; ++tick) {
    est::Measurement<double> measured;
    measured.attitude.is_new = tick % 210 >= missing;
    monitors.update_model(measured, {}, sticks, true, false, core::kTickPeriod);
  }
  return monitors.residual().report(sysid::MonitoredAxis::kRoll).blocks;
}

// Catches a residual that is never complete where the autopilot's clock is slower than ours: 0 in a whole flight.
TEST(FlightMonitors, ATickWithoutAnAttitudeLeavesTheResidualsBlock) {
  EXPECT_GT(blocks(1), 2U);
  EXPECT_EQ(blocks(2), 0U);
}

}  // namespace
}  // namespace m100::app
