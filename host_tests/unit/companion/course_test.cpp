// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/course/course.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "firmware/companion/files/course/course_validation.h"

namespace m100::companion {
namespace {

struct Laid {
  std::unique_ptr<ref::Trajectory<double>> course = std::make_unique<ref::Trajectory<double>>();
  std::vector<CoursePiece> pieces;
  std::string said;  ///< why it was refused; empty: it can be flown
};

/// Lays a course that starts at x = 10, y = -3, z = 1.5 with a heading of 0.3 rad, because places in a course are
/// offsets from the start.
Laid lay(const std::string& text, const CourseLimits& limits = {}) {
  Laid laid;
  ref::Waypoint<double> start;
  start.position_w_m = {10.0, -3.0, 1.5};
  start.yaw_rad = 0.3;
  try {
    laid.pieces = parse_course(text, start, *laid.course, "c");
    validate_course(*laid.course, laid.pieces, start, limits, "c");
  } catch (const CourseError& wrong) {
    laid.said = wrong.what();
  }
  return laid;
}

TEST(Course, WaypointsOfConsecutiveLinesAreOneWayAndKeepTheirLines) {
  const Laid laid =
      lay("limits speed_m_s 1 tilt_deg 10\nthrough 1 0 0 0\n# bend\nthrough 1 1 0.5 0\nstep 1 1 0.5 0 2\n");
  ASSERT_EQ(laid.said, "");
  ASSERT_EQ(laid.pieces.size(), 3U);
  EXPECT_EQ(laid.pieces[0].line, 2);
  EXPECT_EQ(laid.pieces[1].line, 4);
  EXPECT_EQ(laid.pieces[1].begin, laid.pieces[0].end);
  const ref::Motion bend = laid.course->motion(laid.pieces[0].end);
  EXPECT_NEAR(bend[0][0], 11.0, 1e-9);
  EXPECT_GT(std::hypot(bend[0][1], bend[1][1]), 0.1) << "it stops where it should fly through";
}

// Catches a step that ignores the limits in the lines above it: it would fly 6 m at more than 4 m/s.
TEST(Course, AStepBelowLimitsIsGoneToWithinThemAndThenStoodAt) {
  const Laid laid = lay("limits speed_m_s 1 acceleration_m_s2 0.5\nstep 6 0 0 1 20\nstep 6 0 0 1 2\n");
  ASSERT_EQ(laid.said, "");
  ASSERT_EQ(laid.pieces.size(), 2U) << "one a line";
  EXPECT_EQ(laid.pieces[0].end, std::chrono::seconds(20));
  double fastest_m_s = 0.0, hardest_m_s2 = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const ref::Motion at = laid.course->motion(std::chrono::milliseconds(10 * i));
    fastest_m_s = std::max(fastest_m_s, std::abs(at[0][1]));
    hardest_m_s2 = std::max(hardest_m_s2, std::abs(at[0][2]));
  }
  EXPECT_NEAR(fastest_m_s, 1.0, 0.01);
  EXPECT_LE(hardest_m_s2, 0.505);
  const ref::Motion end = laid.course->motion(std::chrono::seconds(19));
  EXPECT_NEAR(end[0][0], 16.0, 1e-9);
  EXPECT_EQ(end[0][1], 0.0);
  const Laid jumps = lay("step 6 0 0 1 20\n");
  EXPECT_NEAR(jumps.course->motion(std::chrono::milliseconds(1))[0][0], 16.0, 1e-9)
      << "the paper's goals are set by hand";
}

// Catches a check of the flight file's speed limit that takes a jump for standing still.
TEST(Course, AJumpThatWouldBecomeFasterThanTheFlightMayIsRefused) {
  const CourseLimits slow{.speed_m_s = 2.0};
  EXPECT_NE(
      lay("step 0 0 0 0 2\nstep 3 0 0 0 9\n", slow).said.find("c:2: 'step': the jump of 3 m reaches up to 3.7 m/s"),
      std::string::npos)
      << lay("step 0 0 0 0 2\nstep 3 0 0 0 9\n", slow).said;
  EXPECT_EQ(lay("step 0.8 0 0 0 9\n", slow).said, "");
  EXPECT_EQ(lay("limits speed_m_s 2\nstep 3 0 0 0 9\n", slow).said, "");
}

TEST(Course, ATableOfTimeAndPlaceIsACourse) {
  const Laid laid = lay("t_s,x_m,y_m,z_m,yaw_deg\n0,0,0,0,0\n2.0, 1, 0, 0, 90\n4.5,1,1,0.5,90\n");
  ASSERT_EQ(laid.said, "");
  ASSERT_EQ(laid.pieces.size(), 2U);
  EXPECT_EQ(laid.pieces[0].end, std::chrono::milliseconds(2000));
  EXPECT_EQ(laid.pieces[1].end, std::chrono::milliseconds(4500));
  const ref::Motion at = laid.course->motion(laid.pieces[0].end, true);
  EXPECT_NEAR(at[0][0], 11.0, 1e-9);
  EXPECT_NEAR(at[3][0], 0.3 + 1.5707963267948966, 1e-9);
}

// A spreadsheet writes a byte order mark and CR LF. A message is a C string, and a zero byte once cut it off.
TEST(Course, BytesThatAreNoTextAreSkippedOrSaid) {
  EXPECT_EQ(lay("\xEF\xBB\xBFt_s,x_m,y_m,z_m\r\n0,0,0,0\r\n2,1,0,0\r\n").said, "");
  EXPECT_EQ(lay(std::string("\0\1\2\n", 4)).said, "c:1: '\\x00\\x01\\x02': no such piece");
  EXPECT_LT(lay(std::string(100000, 'x')).said.size(), 200U);
}

TEST(Course, APolynomialIsInSecondsAndAnAxisThatItDoesNotNameStays) {
  // 10 s^3 - 15 s^4 + 6 s^5 over 2 s, scaled to 2 m
  const Laid laid = lay("polynomial 2 x 0 0 0 2.5 -1.875 0.375\n");
  ASSERT_EQ(laid.said, "");
  EXPECT_NEAR(laid.course->motion(laid.pieces[0].end, true)[0][0], 12.0, 1e-12);
  EXPECT_NEAR(laid.course->motion(std::chrono::seconds(1))[0][1], 1.875, 1e-12);
  EXPECT_EQ(laid.course->motion(std::chrono::seconds(1))[1][0], -3.0);
}

struct Refused {
  const char* name;
  const char* text;
  const char* begins;
  const char* also;  ///< stands somewhere behind it
};
void PrintTo(const Refused& one, std::ostream* out) { *out << one.name; }
class RefusedCourse : public ::testing::TestWithParam<Refused> {};
INSTANTIATE_TEST_SUITE_P(
    Table, RefusedCourse,
    ::testing::Values(
        Refused{"UnknownWord", "hop 1\n", "c:1: 'hop': no such piece", ""},
        Refused{"TooFewNumbers", "\nthrough 1 2 3\n", "c:2: 'through': needs 4 numbers", ""},
        Refused{"NotANumber", "circle 1 fast 2\n", "c:1: 'circle': 'fast' is not a number", ""},
        Refused{"NaN", "step nan 0 0 0 1\n", "c:1: 'step': 'nan' is not a number", ""},
        Refused{"UnknownLimit", "limits velocity 3\n", "c:1: 'limits': 'velocity' is not a limit", "speed_m_s"},
        Refused{"UnknownColumn", "t_s,x_m,y_m,z_m,q\n", "c:1: 't_s': 'q' is not a column", ""},
        Refused{"MissingColumn", "t_s,x_m,y_m\n", "c:1: 't_s': the column z_m is missing", ""},
        Refused{"ShortRow", "t_s,x_m,y_m,z_m\n1,0,0,0\n2,0,0\n", "c:3: 't_s': the row has 3 values", ""},
        Refused{"TimesGoBack", "t_s,x_m,y_m,z_m\n2,0,0,0\n1,0,0,0\n", "c:3: 't_s': times must rise", ""},
        Refused{"TimeStands", "t_s,x_m,y_m,z_m\n0,0,0,0\n1,0,0,0\n2,0,0,0\n2,1,0,0\n", "c:5: 't_s': times must", ""},
        Refused{"ValueMissing", "t_s,x_m,y_m,z_m\n1,0,,0\n", "c:2: 't_s': '' is not a number", ""},
        Refused{"NaNInATable", "t_s,x_m,y_m,z_m\n1,0,0,0\n2,nan,0,0\n", "c:3: 't_s': 'nan' is not a number", ""},
        Refused{"TableOfASpreadsheet", "t_s;x_m;y_m;z_m\n", "c:1: 't_s;x_m;y_m;z_m': no such", "a table begins with"},
        Refused{"TableInQuotes", "\"t_s\",\"x_m\",\"y_m\",\"z_m\"\n", "c:1: ", "a table begins with"},
        // Ten such durations once overflowed their sum.
        Refused{"LongerThanADay", "step 0 0 0 0 9e12\n", "c:1: 'step': the time is longer than a day", ""},
        Refused{"TimeBeyondNumbers", "t_s,x_m,y_m,z_m\n2,0,0,0\n1e300,0,0,0\n",
                "c:3: 't_s': the time is longer than a day", ""},
        Refused{"TableBeginsElsewhere", "t_s,x_m,y_m,z_m\n0,5,0,0\n",
                "c:2: 't_s': the table does not begin where the course is", ""},
        // v^2 / r = 8 m/s^2 needs a tilt of 39.2 degrees; computed as a share of g it would be 46.7.
        Refused{"BendTooSharp", "step 0 0 0 0 1\ncircle 2 4 3\n", "c:2: 'circle': the tilt is 25.",
                "the limit 25 deg, "},
        Refused{"OwnTiltInDegrees", "limits tilt_deg 10 acceleration_m_s2 4\ncircle 2 2 2\n",
                "c:2: 'circle': the tilt is 10.", "the course's own limit 10 deg, "},
        Refused{"OwnSpeed", "limits speed_m_s 1\nquintic 4 0 0 0 4\n", "c:2: 'quintic': the speed is 1.0",
                "course's own limit 1 m/s, 0."},
        Refused{"OwnSpeedOfAStep", "limits speed_m_s 1\nstep 4 0 0 0 4\n",
                "c:2: 'step': the way takes 7.5 s within its limits, but the line allows 4 s", ""},
        Refused{"Climbs", "quintic 0 0 10 0 5\n", "c:1: 'quintic': the climb speed is 2.0", "limit 2 m/s, "},
        Refused{"Turns", "quintic 0 0 0 3 1\n", "c:1: 'quintic': the yaw rate is 1", "limit 100 deg/s, "},
        Refused{"TableTooFast", "t_s,x_m,y_m,z_m\n1,8,0,0\n", "c:2: 't_s': the tilt is ", ", at (0."},
        Refused{"PolynomialElsewhere", "polynomial 2 x 1\n",
                "c:1: 'polynomial': does not join the course before it in place", ""},
        Refused{"PolynomialInMotion", "polynomial 2 x 0 1\n",
                "c:1: 'polynomial': does not join the course before it in velocity", ""},
        Refused{"EndsInMotion", "polynomial 2 x 0 0 0 0.1\n", "c:1: 'polynomial': the course ends in motion, 2.00 s",
                "(0.80, 0.00, 0.00) m"},
        Refused{"StepFromMotion", "polynomial 2 x 0 0 0 0.1\nstep 0 0 0 0 1\n",
                "c:2: 'step': a step must begin at rest, but the course still has velocity, 2.00 s", ""}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(RefusedCourse, NamesFileLineWordAndForALimitTimeAndPlace) {
  const std::string said = lay(GetParam().text).said;
  EXPECT_TRUE(said.starts_with(GetParam().begins)) << said;
  EXPECT_NE(said.find(GetParam().also), std::string::npos) << said;
  EXPECT_EQ(said.find('\n'), std::string::npos);
}

// Catches a course word that the reader knows and the table for --help does not, or the other way round.
TEST(Course, EveryWordOfTheTableIsReadAndStandsInTheHelp) {
  for (const CourseWord& word : kCourseWords) {
    const std::string name(word.word.substr(0, word.word.find(',')));
    EXPECT_NE(course_help().find("  " + std::string(word.word)), std::string::npos);
    const std::string said = lay(name == "t_s" ? "t_s,nothing\n" : name + " nonsense\n").said;
    EXPECT_NE(said, "") << name;
    EXPECT_EQ(said.find("no such piece"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace m100::companion
