// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/files/flight_limits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <sstream>

#include "firmware/core/maths.h"

namespace m100::companion {
namespace {

constexpr const char* kFence = "[fence]\nx_m = [-5.0, 5.0]\ny_m = [-4, 6.0]\nz_m = [0.5, 4.0]\n";

TEST(FlightFile, NeedsNothingButTheThreeRanges) {
  const FlightFile flight = parse_flight(kFence, "f.toml");
  EXPECT_EQ(flight.mode, Mode::kField) << "the default everywhere";
  EXPECT_EQ(flight.fence_y_m.low, -4.0);
  EXPECT_EQ(flight.fence_y_m.high, 6.0);
  EXPECT_EQ(flight.wind_m_s, 5.0);
  EXPECT_EQ(flight.ground_z_m, 0.0);
  EXPECT_EQ(limits_of(flight).pose_fresh, safety::Limits{}.pose_fresh);
  EXPECT_EQ(limits_of(flight).coast, safety::Limits{}.coast);
}

TEST(FlightFile, TheFailsafesTimesAreThoseOfTheFile) {
  const FlightFile flight =
      parse_flight("mode = \"robust\"\n" + std::string(kFence) +
                       "[wind]\nclass_m_s = 8\n[pose]\nfresh_s = 0.1\ncoast_s = 0.7\nlevel_s = 0.5\n",
                   "f.toml");
  EXPECT_EQ(flight.mode, Mode::kRobust);
  EXPECT_EQ(flight.wind_m_s, 8.0);
  EXPECT_EQ(limits_of(flight).pose_fresh, std::chrono::milliseconds(100));
  EXPECT_EQ(limits_of(flight).coast, std::chrono::milliseconds(700));
  EXPECT_EQ(limits_of(flight).level, std::chrono::milliseconds(500));
}

// Catches goals and missions that are flown with more tilt than the file allows, because the limit was applied to
// courses only.
TEST(FlightFile, GoalsKeepTheLimitsOfACourse) {
  const ref::SpeedLimits own;
  const ref::SpeedLimits wide = goal_limits_of(parse_flight(kFence, "f.toml"));
  EXPECT_EQ(wide.speed_m_s, own.speed_m_s);
  EXPECT_EQ(wide.acceleration_m_s2, own.acceleration_m_s2);
  EXPECT_EQ(wide.yaw_rate_rad_s, own.yaw_rate_rad_s);
  const ref::SpeedLimits level = goal_limits_of(parse_flight(std::string(kFence) + "[limits]\ntilt_deg = 5\n", "f"));
  EXPECT_NEAR(ref::tilt_of(level.acceleration_m_s2, 0.0, 0.0), 5.0 * core::kPi / 180.0, 0.001);
  for (const double down : {0.0, 0.05, 0.0872, 0.3, 0.9}) {  // downward share of the acceleration
    const double a = level.acceleration_m_s2;
    EXPECT_LE(ref::tilt_of(a * std::sqrt(1.0 - down * down), 0.0, -a * down), 5.0 * core::kPi / 180.0 + 1e-9) << down;
  }
  const std::string slow = std::string(kFence) + "[limits]\nspeed_m_s = 0.4\nacceleration_m_s2 = 0.5\n";
  EXPECT_EQ(goal_limits_of(parse_flight(slow, "f")).speed_m_s, 0.4);
  EXPECT_EQ(goal_limits_of(parse_flight(slow, "f")).acceleration_m_s2, 0.5);
}

struct Wrong {
  const char* name;
  std::string text;
  const char* said;
};
class WrongFlightFile : public ::testing::TestWithParam<Wrong> {};
INSTANTIATE_TEST_SUITE_P(
    Table, WrongFlightFile,
    ::testing::Values(
        Wrong{"Empty", "", "f.toml: 'fence.x_m': is missing"},
        Wrong{"NoHeight", "\n[fence]\nx_m = [-1, 1]\ny_m = [-1, 1]\n", "f.toml:2: 'fence.z_m': is missing"},
        Wrong{"NoToml", "[fence", "f.toml:1: "},
        Wrong{"UnknownSection", std::string(kFence) + "[fences]\n", "f.toml:5: 'fences': unknown key"},
        Wrong{"UnknownKey", std::string(kFence) + "w_m = 1\n", "f.toml:5: 'fence.w_m': unknown key"},
        Wrong{"UnknownMode", "mode = \"windy\"\n" + std::string(kFence),
              "f.toml:1: 'mode': must be \"field\" or \"robust\""},
        Wrong{"ModeOfNumbers", "mode = 3\n" + std::string(kFence), "f.toml:1: 'mode': must be"},
        Wrong{"OneNumber", "[fence]\nx_m = 5\n", "f.toml:2: 'fence.x_m': must be two numbers"},
        Wrong{"ThreeNumbers", "[fence]\nx_m = [1, 2, 3]\n", "f.toml:2: 'fence.x_m': must be two numbers"},
        Wrong{"TurnedAround", "[fence]\nx_m = [5, -5]\n", "f.toml:2: 'fence.x_m': must be two numbers, the lower"},
        Wrong{"Words", "[fence]\nx_m = [\"-5\", \"5\"]\n", "f.toml:2: 'fence.x_m': must be two numbers"},
        Wrong{"NotANumber", "[fence]\nx_m = [-5, nan]\n", "f.toml:2: 'fence.x_m': nan is outside [-1000, 1000]"},
        Wrong{"StartOutside", "[fence]\nx_m = [1, 5]\ny_m = [-1, 1]\nz_m = [1, 2]\n",
              "f.toml:2: 'fence.x_m': the start, 0, is not inside [1, 5]"},
        Wrong{"TooNarrow", "[fence]\nx_m = [-5, 5]\ny_m = [-0.1, 0.1]\nz_m = [1, 3]\n",
              "f.toml:3: 'fence.y_m': [-0.1, 0.1] leaves less than 0.5 m on a side of the start"},
        Wrong{"TooLow", "[fence]\nx_m = [-5, 5]\ny_m = [-5, 5]\nz_m = [1, 1.2]\n",
              "f.toml:4: 'fence.z_m': [1, 1.2] is lower than 1 m"},
        Wrong{"FloorInTheGround", "[fence]\nx_m = [-1, 5]\ny_m = [-1, 1]\nz_m = [0, 2]\n",
              "f.toml:4: 'fence.z_m': its floor is not above the ground at 0 m"},
        Wrong{"WindAsText", std::string(kFence) + "[wind]\nclass_m_s = \"5\"\n", "f.toml:6: 'wind.class_m_s': must be"},
        Wrong{"AnOldPoseIsFresh", std::string(kFence) + "[pose]\nfresh_s = 0.3\n",
              "f.toml:6: 'pose.fresh_s': 0.3 is outside [0.02, 0.25]"},
        Wrong{"CoastsLongerThanTheObserverPredicts", std::string(kFence) + "[pose]\ncoast_s = 3.1\n",
              "f.toml:6: 'pose.coast_s': 3.1 is outside [0.03, 3]"},
        Wrong{"CoastBeforeAPoseIsOld", std::string(kFence) + "[pose]\nfresh_s = 0.2\ncoast_s = 0.1\n",
              "f.toml:5: 'pose.coast_s': must be longer than pose.fresh_s"},
        Wrong{"NoSigma", std::string(kFence) + "[pose]\nsigma_m = 0\n",
              "f.toml:6: 'pose.sigma_m': 0 is outside [0.0001, 20]"},
        Wrong{"SigmaOfAnIdentityCovariance", std::string(kFence) + "[pose]\nsigma_m = 1\n",
              "f.toml:6: 'pose.sigma_m': at most 0.583333 m can be flown inside this fence"},
        Wrong{"LeverOfTwoNumbers", std::string(kFence) + "[pose]\noffset_m = [0.1, 0]\n",
              "f.toml:6: 'pose.offset_m': must be three numbers: forward, left, up"},
        Wrong{"LeverOverTheDiagonal", std::string(kFence) + "[pose]\noffset_m = [0.6, 0.6, 0.6]\n",
              "f.toml:6: 'pose.offset_m': is longer than 1 m"},
        Wrong{"CoastAsLongAsAPoseIsFresh", std::string(kFence) + "[pose]\nfresh_s = 0.2\ncoast_s = 0.2\n",
              "f.toml:5: 'pose.coast_s': must be longer than pose.fresh_s"},
        Wrong{"NoRange", "[fence]\nx_m = [2, 2]\n", "f.toml:2: 'fence.x_m': must be two numbers, the lower"},
        Wrong{"FenceIsNoTable", "fence = [1]\n", "f.toml:1: 'fence': must be a table"},
        Wrong{"FloorAtTheGround", "[fence]\nx_m = [-1, 5]\ny_m = [-1, 1]\nz_m = [0.5, 2]\nground_z_m = 0.5\n",
              "f.toml:4: 'fence.z_m': its floor is not above the ground at 0.5 m ('fence.ground_z_m')"},
        Wrong{"PoseIsNoTable", "pose = 3\n" + std::string(kFence), "f.toml:1: 'pose': must be a table"}),
    [](const auto& tested) { return tested.param.name; });

TEST_P(WrongFlightFile, IsRefusedWithFileLineAndKey) {
  RecordProperty("promise", "R16");
  try {
    (void)parse_flight(GetParam().text, "f.toml");
    FAIL() << "accepted";
  } catch (const FileError& wrong) {
    EXPECT_TRUE(std::string(wrong.what()).starts_with(GetParam().said)) << wrong.what();
    EXPECT_EQ(std::string(wrong.what()).find('\n'), std::string::npos);
  }
}

struct Laid {
  const char* name;
  const char* course;
  const char* said;  ///< empty: stays inside
};
class CourseInTheBox : public ::testing::TestWithParam<Laid> {};
INSTANTIATE_TEST_SUITE_P(
    Table, CourseInTheBox,
    ::testing::Values(Laid{"Hover", "", ""}, Laid{"AlongTheFence", "step 5 6 2.5 0 5\nquintic -5 -4 -1 0 4\n", ""},
                      Laid{"TheFindingsHundredMetres", "step 100 0 0 0 5\n",
                           "c:1: 'step': x = 100 m is outside the fence, x_m = [-5, 5]"},
                      Laid{"SecondLine", "step 1 0 0 0 5\n# a comment\nquintic 0 -4.1 0 0 5\n",
                           "c:3: 'quintic': y = -4.0"},
                      Laid{"TooHigh", "step 0 0 2.6 0 1\n", "c:1: 'step': z = 4.1 m is outside the fence, z_m"},
                      Laid{"IntoTheGround", "quintic 0 0 -2 0 3\n", "c:1: 'quintic': z = "},
                      Laid{"OnlyTheCornersOfTheSquare", "square 5.5 2 0.5\n", "c:1: 'square': x = "}),
    [](const auto& tested) { return tested.param.name; });

// The start is at x = 10, y = -3. The fence moves with the start in x and y; its height is in world coordinates.
TEST_P(CourseInTheBox, IsTakenOrRefusedByLineAndPlace) {
  RecordProperty("promise", "R16");
  const FlightFile flight = parse_flight(kFence, "f.toml");
  ref::Waypoint<double> start;
  start.position_w_m = {10.0, -3.0, 1.5};
  auto course = std::make_unique<ref::Trajectory<double>>();
  const std::vector<CoursePiece> pieces = parse_course(GetParam().course, start, *course, "c");
  std::string said;
  try {
    validate_inside_fence(flight, start, *course, pieces, "c");
  } catch (const FileError& wrong) {
    said = wrong.what();
  }
  EXPECT_TRUE(GetParam().said[0] == '\0' ? said.empty() : said.starts_with(GetParam().said)) << said;
}

/// The limits of the file's keys, written out a second time, each with a file that holds the key.
struct KeyEdges {
  const char* name;
  std::string before, after;  ///< of the number, in the file
  double low, high, beyond;
};
class FlightKeyLimits : public ::testing::TestWithParam<KeyEdges> {};
INSTANTIATE_TEST_SUITE_P(
    Table, FlightKeyLimits,
    ::testing::Values(
        KeyEdges{"GroundZ", "[fence]\nx_m = [-1, 1]\ny_m = [-1, 1]\nz_m = [999, 1000]\nground_z_m = ", "", 878.0, 998.9,
                 0.2},
        KeyEdges{"Wind", std::string(kFence) + "[wind]\nclass_m_s = ", "", 0.0, 20.0, 1e-6},
        KeyEdges{"PoseFresh", std::string(kFence) + "[pose]\ncoast_s = 3\nfresh_s = ", "", 0.02, 0.25, 1e-6},
        KeyEdges{"PoseCoast", std::string(kFence) + "[pose]\nfresh_s = 0.02\ncoast_s = ", "", 0.03, 3.0, 1e-6},
        KeyEdges{"PoseSigma", "[fence]\nx_m = [-100, 100]\ny_m = [-100, 100]\nz_m = [0.5, 122]\n[pose]\nsigma_m = ", "",
                 1e-4, 20.0, 1e-6},
        KeyEdges{"LeverArm", std::string(kFence) + "[pose]\noffset_m = [0, ", ", 0]\n", -1.0, 1.0, 1e-6},
        KeyEdges{"PoseLevel", std::string(kFence) + "[pose]\nlevel_s = ", "", 0.1, 10.0, 1e-6},
        KeyEdges{"Speed", std::string(kFence) + "[limits]\nspeed_m_s = ", "", 0.1, 20.0, 1e-6},
        KeyEdges{"Acceleration", std::string(kFence) + "[limits]\nacceleration_m_s2 = ", "", 0.1, 20.0, 1e-6},
        KeyEdges{"Tilt", std::string(kFence) + "[limits]\ntilt_deg = ", "", 1.0, 25.0, 1e-6},
        KeyEdges{"YawRate", std::string(kFence) + "[limits]\nyaw_rate_deg_s = ", "", 1.0, 100.0, 1e-6},
        KeyEdges{"LowBattery", std::string(kFence) + "[battery]\nlow_percent = ", "", 0.0, 90.0, 1e-6},
        KeyEdges{"LeftSide", "[fence]\ny_m = [-1, 1]\nz_m = [1, 3]\nx_m = [", ", 5]\n", -1000.0, -0.5, 0.01},
        KeyEdges{"RightSide", "[fence]\ny_m = [-1, 1]\nz_m = [1, 3]\nx_m = [-5, ", "]\n", 0.5, 1000.0, 0.01},
        KeyEdges{"FarSide", "[fence]\nx_m = [-1, 1]\nz_m = [1, 3]\ny_m = [-5, ", "]\n", 0.5, 1000.0, 0.01},
        KeyEdges{"NearSide", "[fence]\nx_m = [-1, 1]\nz_m = [1, 3]\ny_m = [", ", 5]\n", -1000.0, -0.5, 0.01},
        KeyEdges{"Ceiling", "[fence]\nx_m = [-1, 1]\ny_m = [-1, 1]\nz_m = [1, ", "]\n", 2.0, 122.0, 0.01}),
    [](const auto& tested) { return tested.param.name; });

TEST_P(FlightKeyLimits, AreTakenAtTheirLastNumberAndRefusedAtTheNext) {
  RecordProperty("promise", "R16");
  const auto taken = [](double value) {
    std::ostringstream text;
    text.precision(12);
    text << GetParam().before << value << GetParam().after;
    try {
      (void)parse_flight(text.str(), "f.toml");
      return true;
    } catch (const FileError&) {
      return false;
    }
  };
  EXPECT_TRUE(taken(GetParam().low));
  EXPECT_TRUE(taken(GetParam().high));
  EXPECT_FALSE(taken(GetParam().low - GetParam().beyond));
  EXPECT_FALSE(taken(GetParam().high + GetParam().beyond));
}

TEST(FlightFile, EveryKeyReachesTheFlightInItsUnit) {
  const FlightFile said = parse_flight(std::string(kFence) +
                                           "ground_z_m = -0.25\n[limits]\nspeed_m_s = 2\nacceleration_m_s2 = 3\n"
                                           "tilt_deg = 18\nyaw_rate_deg_s = 36\n[battery]\nlow_percent = 25\n"
                                           "[pose]\nfresh_s = 0.1\n",
                                       "f");
  EXPECT_EQ(said.ground_z_m, -0.25);
  EXPECT_EQ(said.battery_low_percent, 25.0);
  const CourseLimits course = course_limits_of(said);
  EXPECT_EQ(course.speed_m_s, 2.0);
  EXPECT_EQ(course.acceleration_m_s2, 3.0);
  EXPECT_NEAR(course.tilt_rad, core::kPi / 10.0, 1e-12);
  EXPECT_NEAR(course.yaw_rate_rad_s, core::kPi / 5.0, 1e-12);
  EXPECT_TRUE(limits_of(said).pose_fresh_is_set);
  const FlightFile unsaid = parse_flight(kFence, "f");
  EXPECT_FALSE(limits_of(unsaid).pose_fresh_is_set);
  EXPECT_EQ(limits_of(unsaid).level, safety::Limits{}.level);
  EXPECT_EQ(course_limits_of(unsaid).speed_m_s, CourseLimits{}.speed_m_s);
  EXPECT_EQ(course_limits_of(unsaid).tilt_rad, CourseLimits{}.tilt_rad);
  EXPECT_NEAR(goal_limits_of(said).yaw_rate_rad_s, core::kPi / 5.0, 1e-12);
  // The sides are relative to the start in x and y, and world coordinates in height.
  ref::Waypoint<double> start;
  start.position_w_m = {10.0, -20.0, 1.5};
  const core::Fence fence = fence_of(said, start);
  EXPECT_EQ(fence.side[0].low_m, 5.0);
  EXPECT_EQ(fence.side[0].high_m, 15.0);
  EXPECT_EQ(fence.side[1].low_m, -24.0);
  EXPECT_EQ(fence.side[1].high_m, -14.0);
  EXPECT_EQ(fence.side[2].low_m, 0.5);
  EXPECT_EQ(fence.side[2].high_m, 4.0);
  EXPECT_EQ(fence.wind_m_s, 5.0);
}

// A pose is accurate to a millimetre: a place one millimetre outside counts as inside, two millimetres do not.
TEST(FlightFile, AStartIsInsideToAMillimetre) {
  const FlightFile flight = parse_flight(kFence, "f.toml");
  const auto inside = [&flight](double z_m) {
    ref::Waypoint<double> start;
    start.position_w_m = {0.0, 0.0, z_m};
    auto course = std::make_unique<ref::Trajectory<double>>();
    course->hold(start);
    try {
      validate_inside_fence(flight, start, *course, {}, "c");
      return true;
    } catch (const FileError& wrong) {
      EXPECT_TRUE(std::string(wrong.what()).starts_with("the start of the flight: z = ")) << wrong.what();
      return false;
    }
  };
  EXPECT_TRUE(inside(0.4995));
  EXPECT_FALSE(inside(0.498));
  EXPECT_TRUE(inside(4.0005));
  EXPECT_FALSE(inside(4.002));
}

}  // namespace
}  // namespace m100::companion
