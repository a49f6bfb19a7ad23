// SPDX-License-Identifier: BSD-3-Clause
// The fence of the flight file, with the whole program (promise R16).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "firmware/companion/files/flight_file.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/experiments/flight.h"

namespace m100::scenario {
namespace {

using lab::experiments::FlightPlan;
using lab::experiments::FlightResult;
using lab::experiments::TracePoint;

constexpr double kHalf_m = 5.0;
constexpr double kMeasuredDrag_per_s = sim::Air::kMeasuredDrag_per_s;
constexpr const char* kFlight = "[fence]\nx_m = [-5, 5]\ny_m = [-5, 5]\nz_m = [0.5, 4]\n[wind]\nclass_m_s = 5\n";

struct Case {
  const char* name;
  const char* course;
  double pose_lost_at_s;  ///< from the start of the course; negative: never
  double wind_m_s;
  double drag_per_s = 0.3;  ///< of the simulated aircraft; the vehicle file has 0.01
  double tilt_limit_rad = mpc::generated::kVehicle.translation.tilt_limit_rad;  ///< of the vehicle file
  double handed_over_m_s = 1.0;  ///< largest speed at the handover after a lost pose
};

void PrintTo(const Case& one, std::ostream* out) { *out << one.name; }

class Fence : public ::testing::TestWithParam<Case> {};

/// The extremes of a flight until the pilot has control.
struct Extremes {
  double farthest_m = 0.0, lowest_m = 1e9, highest_m = 0.0;
  double last_speed_m_s = 0.0;
};

/// Flies the case. The course is not checked before the flight.
Extremes flown(const Case& test, std::uint64_t seed) {
  FlightPlan plan;
  plan.plant = sim::measured_plant();
  plan.plant.air.linear_drag_per_s = test.drag_per_s;
  plan.plant.air.wind_m_s = {test.wind_m_s, 0.0, 0.0};
  plan.plant.air.gust_m_s = 0.3 * test.wind_m_s;
  plan.pilot_holds_position = true;
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  plan.vehicle.vehicle.translation.tilt_limit_rad = test.tilt_limit_rad;
  plan.flight_file = companion::parse_flight(kFlight, "flight.toml");
  plan.course = test.course;
  plan.duration_s = 12.0;
  plan.seed = seed;
  plan.disturb = [&test](sim::World& world, double t_s) {
    if (test.pose_lost_at_s >= 0.0 && t_s >= test.pose_lost_at_s) {
      world.pose_source().set_faults({.silent = true});
    }
  };
  const FlightResult result = lab::experiments::fly(plan);
  EXPECT_TRUE(result.flew);
  Extremes out;
  for (const TracePoint& point : result.trace) {
    if (point.failsafe_state == static_cast<int>(safety::FailsafeState::kSilent)) {
      break;  // the pilot has control
    }
    out.farthest_m = std::max({out.farthest_m, std::abs(point.position_m[0]), std::abs(point.position_m[1])});
    out.lowest_m = std::min(out.lowest_m, point.position_m[2]);
    out.highest_m = std::max(out.highest_m, point.position_m[2]);
    out.last_speed_m_s = std::hypot(point.velocity_m_s[0], point.velocity_m_s[1]);
  }
  return out;
}

// Catches goals that are not limited to the fence, and speeds from which the aircraft cannot stop.
TEST_P(Fence, IsNotLeftWhileTheProgramCommands) {
  RecordProperty("promise", "R16");
  const Case& test = GetParam();
  const Extremes extremes = flown(test, 3);
  EXPECT_LT(extremes.farthest_m, kHalf_m);
  EXPECT_GT(extremes.lowest_m, 0.5);
  EXPECT_LT(extremes.highest_m, 4.0);
  if (test.pose_lost_at_s >= 0.0) {
    EXPECT_LT(extremes.last_speed_m_s, test.handed_over_m_s) << "handed over in motion";
  }
}

// The worst place of a lost pose: at speed, downwind, with a drag that the vehicle file does not know.
TEST(FenceHandOver, IsFastestDownwindWithUnknownDrag) {
  RecordProperty("promise", "R16");
  double fastest_m_s = 0.0;
  int flights = 0;
  for (double lost_at_s = 5.5; lost_at_s < 6.6; lost_at_s += 0.1) {
    for (const std::uint64_t seed : {3U, 4U}) {
      const Case test{"", "step -4 0 0 0 4\nstep 100 0 0 0 60\n", lost_at_s, 5.0};
      fastest_m_s = std::max(fastest_m_s, flown(test, seed).last_speed_m_s);
      ++flights;
    }
  }
  EXPECT_LT(fastest_m_s, 1.5);
  char text[64];
  static_cast<void>(std::snprintf(text, sizeof text, "%.1f m/s (%d flights)", fastest_m_s, flights));
  RecordProperty("figure.fence.handed_over", text);
}

INSTANTIATE_TEST_SUITE_P(Courses, Fence,
                         ::testing::Values(Case{"FarAway", "step 0 0 0 0 1\nstep 100 0 0 0 60\n", -1.0, 0.0},
                                           Case{"FarAwayDownwind", "step 0 0 0 0 1\nstep 100 0 0 0 60\n", -1.0, 5.0},
                                           Case{"FarAcross", "step -4 0 0 0 4\nstep 100 -60 0 0 60\n", -1.0, 5.0},
                                           Case{"IntoTheGround", "step 0 0 0 0 1\nstep 0 0 -10 0 60\n", -1.0, 0.0},
                                           Case{"IntoTheSky", "step 0 0 0 0 1\nstep 0 0 50 0 60\n", -1.0, 0.0}),
                         [](const auto& one) { return std::string(one.param.name); });

// Catches a fence that assumes the braking of another vehicle: with that of 25 degrees the first case leaves by metres.
INSTANTIATE_TEST_SUITE_P(
    LittleTilt, Fence,
    ::testing::Values(Case{"Downwind3", "step -4 0 0 0 6\nstep 100 0 0 0 60\n", -1.0, 3.0, 0.3, 0.2},
                      Case{"Downwind4", "step -4 0 0 0 6\nstep 100 0 0 0 60\n", -1.0, 4.0, 0.3, 0.2},
                      Case{"PoseLost", "step -4 0 0 0 6\nstep 100 0 0 0 60\n", 8.0, 0.0, kMeasuredDrag_per_s, 0.2},
                      Case{"PoseLostInDrag", "step -4 0 0 0 6\nstep 100 0 0 0 60\n", 8.5, 0.0, 0.3, 0.2},
                      Case{"Across", "step -4 0 0 0 6\nstep 100 -100 0 0.8 60\n", -1.0, 2.0, 0.3, 0.2}),
    [](const auto& one) { return std::string(one.param.name); });

INSTANTIATE_TEST_SUITE_P(
    PoseLost, Fence,
    ::testing::Values(Case{"Starting", "step -4 0 0 0 4\nstep 100 0 0 0 60\n", 5.0, 0.0},
                      Case{"AtSpeed", "step -4 0 0 0 4\nstep 100 0 0 0 60\n", 5.7, 0.0, kMeasuredDrag_per_s},
                      Case{"Braking", "step -4 0 0 0 4\nstep 100 0 0 0 60\n", 6.3, 0.0, kMeasuredDrag_per_s},
                      Case{"AtSpeedDownwind", "step -4 0 0 0 4\nstep 100 0 0 0 60\n", 5.7, 5.0},
                      Case{"BrakingDownwind", "step -4 0 0 0 4\nstep 100 0 0 0 60\n", 6.3, 5.0, kMeasuredDrag_per_s},
                      Case{"AtSpeedInDrag", "step -4 0 0 0 4\nstep 100 0 0 0 60\n", 5.7, 0.0},
                      Case{"BrakingInDrag", "step -4 0 0 0 4\nstep 100 0 0 0 60\n", 6.3, 0.0},
                      // Half a second of neutral sticks without a pose adds 0.75 m/s and more in this wind.
                      Case{"BrakingDownwindInDrag", "step -4 0 0 0 4\nstep 100 0 0 0 60\n", 6.3, 5.0, 0.3,
                           mpc::generated::kVehicle.translation.tilt_limit_rad, 1.5},
                      Case{"Across", "step -4 -4 0 0 4\nstep 100 100 0 0 60\n", 5.7, 0.0},
                      // Half a second of neutral sticks adds 0.4 m/s in this wind. Of 126 such losses (5.5 to 6.5 s, 6
                      // seeds), 13 were handed over above 1 m/s, at most at 1.075.
                      Case{"AcrossDiagonal", "step -4 -4 0 0.785 4\nstep 100 100 0 0.785 60\n", 6.0, 3.0, 0.3,
                           mpc::generated::kVehicle.translation.tilt_limit_rad, 1.1},
                      Case{"HoveringInWind", "step 0 0 0 0 60\n", 4.0, 5.0}),
    [](const auto& one) { return std::string(one.param.name); });

struct Storm {
  const char* name;
  double wind_m_s;
  const char* half_m;  ///< half width of the fence along x
  std::string descent;
};

void PrintTo(const Storm& one, std::ostream* out) { *out << one.name; }

class InAStorm : public ::testing::TestWithParam<Storm> {};

// Catches a program that lets the wind carry the aircraft away without a message, one that then hands it over in motion
// (half a second of level sticks adds 2 m/s in this wind), and one with a false alarm while the position is held.
TEST_P(InAStorm, AnAircraftThatCannotStayIsHandedOverByNameAndNotInMotion) {
  RecordProperty("promise", "R12");
  FlightPlan plan;
  plan.plant = sim::measured_plant();
  plan.plant.air.linear_drag_per_s = 0.3;
  plan.plant.air.wind_m_s = {GetParam().wind_m_s, 0.0, 0.0};
  plan.pilot_holds_position = true;
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  const std::string half_m = GetParam().half_m;
  plan.flight_file = companion::parse_flight(
      "[fence]\nx_m = [-" + half_m + ", " + half_m + "]\ny_m = [-5, 5]\nz_m = [0.5, 4]\n", "flight.toml");
  plan.course = "step 0 0 0 0 60\n";
  plan.duration_s = 16.0;
  plan.seed = 3;
  const FlightResult result = lab::experiments::fly(plan);
  ASSERT_TRUE(result.flew);
  EXPECT_EQ(result.descent, GetParam().descent);
  double last_speed_m_s = 0.0;
  bool silent = false;
  for (const TracePoint& point : result.trace) {
    if (point.failsafe_state == static_cast<int>(safety::FailsafeState::kSilent)) {
      silent = true;
      break;
    }
    last_speed_m_s = std::hypot(point.velocity_m_s[0], point.velocity_m_s[1]);
  }
  EXPECT_EQ(silent, GetParam().descent != "given_back");
  EXPECT_LT(last_speed_m_s, 1.0);
  EXPECT_LT(result.largest_tilt_deg, 35.0);
}

INSTANTIATE_TEST_SUITE_P(Winds, InAStorm,
                         ::testing::Values(Storm{"Strong", 15.5, "30", "place_lost"},
                                           Storm{"VeryStrong", 17.0, "30", "place_lost"},
                                           Storm{"Held", 13.0, "5", "given_back"},
                                           Storm{"BesideTheFence", 16.5, "5", "fence_left"}),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace m100::scenario
