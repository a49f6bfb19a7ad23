// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdio>

#include "firmware/ref/trajectory.h"
#include "host_tests/scenario/ctl/bench.h"

namespace m100::scenario {
namespace {

struct Plant {
  const char* name;
  World world;
};

class ClosedLoop : public ::testing::TestWithParam<Plant> {
 protected:
  static Flight hover(double duration_s) {
    Flight flight;
    flight.duration_s = duration_s;
    flight.reference = [](double, double) { return hover_at(0.0, 0.0, 1.0); };
    return flight;
  }
  static void report(const char* what, const Result& r) {
    std::printf("%-22s x %.4f y %.4f z %.4f m rms, mean %.4f %.4f m, peak %.3f m, tilt %.3f deg, input step %.4f deg\n",
                what, r.x_rms_m, r.y_rms_m, r.z_rms_m, r.x_mean_m, r.y_mean_m, r.position_peak_m, r.tilt_rms_deg,
                r.input_variation_deg);
  }
};

TEST_P(ClosedLoop, HoversInWindWithGusts) {
  World world = GetParam().world;
  world.wind_m_s2 = 1.5;
  world.gust_m_s2 = 0.5;
  const Result r = fly<double, double>(world, vehicle_of(world), hover(60.0));
  report("hover, wind and gusts", r);
  EXPECT_LE(r.x_rms_m, 0.05);
  EXPECT_LE(r.y_rms_m, 0.05);
}

TEST_P(ClosedLoop, LeavesNoSteadyOffsetInSteadyWindWithTrimAndGainErrors) {
  World world = GetParam().world;
  world.wind_m_s2 = 1.5;
  world.trim_rad = 0.03;
  world.command_gain = 0.95;
  const Result r = fly<double, double>(world, vehicle_of(world), hover(40.0));
  report("steady wind, trim", r);
  EXPECT_NEAR(r.x_mean_m, 0.0, 0.005);
  EXPECT_NEAR(r.y_mean_m, 0.0, 0.005);
}

TEST_P(ClosedLoop, HoldsItsTiltStillInCalm) {
  const Result r = fly<double, double>(GetParam().world, vehicle_of(GetParam().world), hover(40.0));
  report("hover, calm", r);
  EXPECT_LE(r.tilt_rms_deg, 0.5);
}

TEST_P(ClosedLoop, FollowsASinusoid) {
  Flight flight;
  flight.duration_s = 40.0;
  flight.reference = [](double now_s, double lead_s) { return sinusoid(2.0, 0.9, now_s, lead_s); };
  const Result r = fly<double, double>(GetParam().world, vehicle_of(GetParam().world), flight);
  report("sinusoid 2 m 0.9 rad/s", r);
  EXPECT_LE(r.x_rms_m, 0.010);
}

TEST_P(ClosedLoop, FollowsQuinticWaypoints) {
  ref::Trajectory<double> course;
  ref::Waypoint<double> place;
  place.position_w_m = {0.0, 0.0, 1.0};
  course.hold(place);
  const double way[][2] = {{1.5, 0.0}, {1.5, 1.0}, {0.0, 1.5}, {-1.0, 0.5}, {0.5, -1.0}, {2.0, 0.0}, {0.0, 0.0}};
  for (int round = 0; round < 2; ++round) {
    for (const auto& [x, y] : way) {
      place.position_w_m = {x, y, 1.0};
      ASSERT_EQ(course.append_quintic(place, std::chrono::milliseconds(2500)), core::Status::kOk);
    }
  }
  Flight flight;
  flight.settle_s = 5.0;
  flight.duration_s = 40.0;
  flight.reference = [&](double now_s, double lead_s) {
    const auto micro = [](double s) { return core::Duration(static_cast<core::Duration::rep>(s * 1e6 + 0.5)); };
    return course.window(core::TimePoint(micro(now_s)) - std::chrono::seconds(5), micro(lead_s));
  };
  const Result r = fly<double, double>(GetParam().world, vehicle_of(GetParam().world), flight);
  report("waypoints every 2.5 s", r);
  EXPECT_LE(r.x_rms_m, 0.012);
  EXPECT_LE(r.y_rms_m, 0.012);
}

TEST_P(ClosedLoop, StaysWithin15CentimetresWhenThePoseDropsOut) {
  World world = GetParam().world;
  world.wind_m_s2 = 1.5;
  world.gust_m_s2 = 0.3;  // with 0.5 the gusts alone reach 0.14 m
  Flight flight = hover(60.0);
  flight.pose_lost = [](double now_s) { return now_s > 15.0 && now_s - 3.0 * static_cast<int>(now_s / 3.0) < 0.2; };
  const Result r = fly<double, double>(world, vehicle_of(world), flight);
  report("pose dropouts 0.2 s", r);
  EXPECT_LE(r.position_peak_m, 0.15);
  EXPECT_EQ(r.ekf.recoveries, 0U);
}

INSTANTIATE_TEST_SUITE_P(Plants, ClosedLoop, ::testing::Values(Plant{"A", plant_a()}, Plant{"B", plant_b()}),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace m100::scenario
