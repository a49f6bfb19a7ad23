// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdio>

#include "host_tests/scenario/ctl/bench.h"

namespace m100::scenario {
namespace {

/// Measured results of this test, m.
struct Measured {
  double calm_m, headings_m, at_25_hz_m;
};

struct Plant {
  const char* name;
  World world;
  Measured measured;
};

class ClosedLoop : public ::testing::TestWithParam<Plant> {
 protected:
  static void report(const char* what, const Result& r) {
    std::printf("%-22s x %.4f y %.4f z %.4f m rms, mean %.4f %.4f m, peak %.3f m, tilt %.3f deg, input step %.4f deg\n",
                what, r.x_rms_m, r.y_rms_m, r.z_rms_m, r.x_mean_m, r.y_mean_m, r.position_peak_m, r.tilt_rms_deg,
                r.input_variation_deg);
  }
};

// Uses the same vehicle, weights and noise as every flight below.
TEST_P(ClosedLoop, KeepsItsMargins) {
  for (const auto axis : {lab::gains::Axis::kX, lab::gains::Axis::kY}) {
    const model::Vehicle vehicle = vehicle_of(GetParam().world);
    const lab::gains::Margins m = lab::gains::flown_margins_of(vehicle, vehicle, axis, kBenchTiming);
    std::printf("margins: peak sensitivity %.2f, gain %.2f, phase %.0f deg, delay %.0f ms\n", m.peak_sensitivity,
                m.gain_margin, m.phase_margin_rad * 57.29577951, 1e3 * m.delay_margin_s);
    EXPECT_TRUE(m.stable);
    if (GetParam().world.time_constant_s == 0.0) {  // a first-order axis misses these limits (two_plants_test.cpp)
      EXPECT_LE(m.peak_sensitivity, 1.6);
      EXPECT_GE(m.delay_margin_s, 0.1);
    }
  }
}

// Catches a law or filter that works only in one arithmetic.
TEST_P(ClosedLoop, FliesTheSameInFloatAndInFixedPoint) {
  World world = GetParam().world;
  world.wind_m_s2 = 1.5;
  world.gust_m_s2 = 0.5;
  world.pose_delay_s = 0.02;
  const Result wide = fly<double, double>(world, vehicle_of(world), hover(40.0));
  const Result single = fly<float, float>(world, vehicle_of(world), hover(40.0));
  const Result fixed = fly<core::Fixed, float>(world, vehicle_of(world), hover(40.0));
  report("float", single);
  report("fixed point", fixed);
  EXPECT_NEAR(single.x_rms_m, wide.x_rms_m, 1e-4);
  EXPECT_NEAR(fixed.x_rms_m, wide.x_rms_m, 1e-4);
}

// Catches a command that is not rotated by yaw, or in the wrong direction, which is unstable at a quarter turn.
TEST_P(ClosedLoop, FliesAtEveryHeading) {
  for (const double yaw_rad : {0.8, 1.6, 3.1, -2.0}) {
    World world = GetParam().world;
    world.yaw_rad = yaw_rad;
    world.wind_m_s2 = 1.0;
    Flight flight = hover(30.0);
    flight.reference = [yaw_rad](double, double) {
      ref::Window<double> window = hover_at(0.0, 0.0, 1.0);
      window.yaw_rad = yaw_rad;
      return window;
    };
    const Result r = fly<double, double>(world, vehicle_of(world), flight);
    EXPECT_LE(r.x_rms_m, kMargin * GetParam().measured.headings_m) << yaw_rad;
    EXPECT_LE(r.y_rms_m, kMargin * GetParam().measured.headings_m) << yaw_rad;
  }
}

// The default command channel (Virtual RC) sends only every 40 ms.
TEST_P(ClosedLoop, FliesWhenCommandsLeaveEvery40Milliseconds) {
  World world = GetParam().world;
  world.command_period_s = 0.04;
  world.pose_delay_s = 0.02;
  world.wind_m_s2 = 1.5;
  const Result r = fly<double, double>(world, vehicle_of(world), hover(40.0));
  report("25 Hz, steady wind", r);
  EXPECT_LE(r.x_rms_m, kMargin * GetParam().measured.at_25_hz_m);
  EXPECT_LE(r.tilt_rms_deg, 0.7);
}

TEST_P(ClosedLoop, HoldsItsTiltStillInCalm) {
  const Result r = fly<double, double>(GetParam().world, vehicle_of(GetParam().world), hover(40.0));
  report("hover, calm", r);
  EXPECT_LE(r.tilt_rms_deg, 0.5);
  EXPECT_LE(r.x_rms_m, kMargin * GetParam().measured.calm_m);
  EXPECT_LE(r.y_rms_m, kMargin * GetParam().measured.calm_m);
  EXPECT_LE(r.z_rms_m, kMargin * GetParam().measured.calm_m);
}

constexpr Measured kMeasuredA{.calm_m = 0.0009, .headings_m = 0.0012, .at_25_hz_m = 0.0013};
constexpr Measured kMeasuredB{.calm_m = 0.0009, .headings_m = 0.0012, .at_25_hz_m = 0.0014};
INSTANTIATE_TEST_SUITE_P(Plants, ClosedLoop,
                         ::testing::Values(Plant{"A", plant_a(), kMeasuredA}, Plant{"B", plant_b(), kMeasuredB}),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace m100::scenario
