// SPDX-License-Identifier: BSD-3-Clause
// What the autopilot's telemetry says of a flight that is out of control; each item has to come from its own place.
#include "firmware/app/flight_state_monitor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "firmware/app/tick_timer.h"
#include "host_tests/sim/ports/link_bench.h"

namespace m100::app {
namespace {

using safety::FlightFailure;
using std::chrono::milliseconds;
using Vector3 = core::Vector<double, 3>;

struct FlightStateMonitorTest : ::testing::Test {
  sim::LinkBench bench{{}};
  sim::VehicleState& state = bench.vehicle.mutable_state();
  FaultIsolation<double> isolation{{}};
  FlightStateMonitor<double> monitor;
  est::Estimate<double> estimate;
  core::Vector<double, 2> model_tilt_rad = core::Vector<double, 2>::Zero();
  double roll_rad = 0.0;  ///< that the isolation sees

  void SetUp() override {
    ASSERT_TRUE(bench.run_until(safety::AuthorityStage::kReady));
    ASSERT_EQ(after(milliseconds(500)), FlightFailure::kNone);
  }
  FlightFailure after(core::Duration time) {
    for (core::Duration passed{0}; passed < time; passed += core::kTickPeriod) {
      bench.tick();
      est::ImuSample<double> imu{.attitude_is_new = true, .force_is_new = true, .roll_rad = roll_rad};
      imu.force_b.z() = 1.0;  // the unit is g
      isolation.update(imu, {}, {}, {0.0, 0.0}, safety::FailsafeState::kNominal, core::kTickPeriod);
      monitor.update(bench.link, estimate, model_tilt_rad, isolation, core::kTickPeriod);
    }
    return monitor.status().failure;
  }
  FlightFailure after_blow(double force_g, double climb_m_s) {
    state.velocity_w_m_s.z() = climb_m_s;
    state.specific_force_b_m_s2.z() = force_g * 9.8066;
    (void)after(milliseconds(30));
    state.specific_force_b_m_s2.z() = 9.8066;
    return after(milliseconds(1500));
  }
};

TEST_F(FlightStateMonitorTest, ATiltThatTheRatesDoNotContradictIsAFailure) {
  state.rotation_wb = {.w = std::cos(0.5), .x = std::sin(0.5), .y = 0.0, .z = 0.0};
  EXPECT_EQ(after(milliseconds(1500)), FlightFailure::kTilt);
  for (int i = 0; i < 300; ++i) {
    roll_rad = 0.2 * std::sin(0.05 * i);  // without a rate
    (void)after(core::kTickPeriod);
  }
  ASSERT_TRUE(isolation.attitude_is_contradicted());
  EXPECT_EQ(after(milliseconds(100)), FlightFailure::kNone);
}

TEST_F(FlightStateMonitorTest, ARevolutionASecondIsTumbling) {
  state.rate_b_rad_s = Vector3(0.0, 0.0, 6.0);
  EXPECT_EQ(after(milliseconds(500)), FlightFailure::kNone);
  state.rate_b_rad_s = Vector3(0.0, 0.0, 6.5);
  EXPECT_EQ(after(milliseconds(500)), FlightFailure::kTumbling);
}

TEST_F(FlightStateMonitorTest, AFallNeedsASmallForceAndASinkingAircraft) {
  state.velocity_w_m_s = Vector3(-9.0, 9.0, -1.0);
  state.specific_force_b_m_s2.z() = 0.19 * 9.8066;
  EXPECT_EQ(after(milliseconds(500)), FlightFailure::kNone);
  state.velocity_w_m_s.z() = -2.0;
  EXPECT_EQ(after(milliseconds(500)), FlightFailure::kFreeFall);
  state.specific_force_b_m_s2.z() = 0.21 * 9.8066;
  EXPECT_EQ(after(milliseconds(500)), FlightFailure::kNone);
}

TEST_F(FlightStateMonitorTest, ACrashIsALeanOrABlowAndThenNoMotion) {
  estimate.x.tilt_rad = 0.2;
  estimate.y.tilt_rad = -0.1;
  model_tilt_rad = {-0.15, 0.25};
  EXPECT_EQ(after(milliseconds(2500)), FlightFailure::kNone) << "0.495 rad";
  model_tilt_rad = {-0.2, 0.3};
  EXPECT_EQ(after(milliseconds(2500)), FlightFailure::kCrash) << "0.566 rad";
  model_tilt_rad = {0.2, -0.1};
  EXPECT_EQ(after_blow(2.9, -0.05), FlightFailure::kNone);
  EXPECT_EQ(after_blow(410.0, -0.05), FlightFailure::kNone) << "no sensor measures it";
  EXPECT_EQ(after_blow(3.1, -0.2), FlightFailure::kNone) << "it moves";
  EXPECT_EQ(after_blow(390.0, -0.05), FlightFailure::kCrash);
}

// The status comes ten times a second; a time that is another item's would grow in every tick.
TEST_F(FlightStateMonitorTest, TheGroundIsTheFlightStatus) {
  EXPECT_EQ(monitor.status().on_ground_for, core::Duration{0});
  state.in_air = state.motors_on = false;
  std::set<core::Duration> times;
  for (int i = 0; i < 100; ++i) {
    (void)after(core::kTickPeriod);
    times.insert(monitor.status().on_ground_for);
  }
  EXPECT_GE(*times.rbegin(), milliseconds(880));
  EXPECT_LE(times.size(), 12U);
}

}  // namespace
}  // namespace m100::app
