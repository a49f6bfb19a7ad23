// SPDX-License-Identifier: BSD-3-Clause
// How a trajectory behaves without pieces, at its ends, and with invalid input.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "firmware/ref/trajectory.h"

namespace m100::ref::refusals {
namespace {

using namespace std::chrono_literals;
using core::Status;
using Course = Trajectory<double>;

Waypoint<double> place(double x_m, double y_m = 0.0, double z_m = 1.0, double yaw_rad = 0.0) {
  return {.position_w_m = {x_m, y_m, z_m}, .yaw_rad = yaw_rad};
}

/// A course that stands at (1, 2, 3) with a heading of 4 rad.
std::unique_ptr<Course> standing() {
  auto course = std::make_unique<Course>();
  course->hold(place(1.0, 2.0, 3.0, 4.0));
  return course;
}

TEST(Standing, IsARestAtThePlaceForEver) {
  const auto course = standing();
  EXPECT_EQ(course->pieces(), 0U);
  EXPECT_EQ(course->duration(), 0us);
  EXPECT_TRUE(course->finished(core::TimePoint{}));
  const Window<double> window = course->window(core::TimePoint(7s), 30ms);
  for (const AxisReference<double>& x : window.x) {
    EXPECT_EQ(x.position_m, 1.0);
    EXPECT_EQ(x.velocity_m_s, 0.0);
  }
  for (const AxisReference<double>& y : window.y) {
    EXPECT_EQ(y.position_m, 2.0);
  }
  EXPECT_EQ(window.height.position_m, 3.0);
  EXPECT_EQ(window.height.velocity_m_s, 0.0);
  EXPECT_NEAR(window.yaw_rad, 4.0 - 2.0 * std::numbers::pi, 1e-12) << "a heading within half a turn";
  EXPECT_EQ(window.yaw_rate_rad_s, 0.0);
  EXPECT_TRUE(window.constant);
  const Motion motion = course->motion(5s);
  EXPECT_EQ(motion[0][0], 1.0);
  EXPECT_EQ(motion[1][0], 2.0);
  EXPECT_EQ(motion[2][0], 3.0);
  EXPECT_EQ(motion[3][0], 4.0);
  EXPECT_EQ(motion[0][1], 0.0);
  EXPECT_EQ(course->end().position_w_m.y(), 2.0);
}

TEST(Standing, EndsWithItsLastPieceToTheMicrosecond) {
  const auto course = standing();
  ASSERT_EQ(course->append_step(place(2.0), 1s), Status::kOk);
  ASSERT_EQ(course->append_quintic(place(5.0), 2s), Status::kOk);
  course->start(core::TimePoint(10s));
  EXPECT_EQ(course->duration(), 3s);
  EXPECT_EQ(course->pieces(), 2U);
  EXPECT_EQ(course->piece_end(0), 1s);
  EXPECT_EQ(course->piece_end(1), 3s);
  EXPECT_FALSE(course->finished(core::TimePoint(13s - 1us)));
  EXPECT_TRUE(course->finished(core::TimePoint(13s)));
  EXPECT_EQ(course->end().position_w_m.x(), 5.0);
  EXPECT_EQ(course->window(core::TimePoint(20s), 0us).x[0].position_m, 5.0);
  EXPECT_EQ(course->window(core::TimePoint(5s), 0us).x[0].position_m, 2.0) << "before its time, at its first piece";
}

/// A function that appends a way to a given place. The test checks its status for a bad place; with a good place every
/// way is valid.
struct Append {
  const char* name;
  Status (*with_place)(Course&, const Waypoint<double>&);
};
class RefusedPlace : public ::testing::TestWithParam<Append> {};
INSTANTIATE_TEST_SUITE_P(
    Table, RefusedPlace,
    ::testing::Values(Append{"Step", [](Course& c, const Waypoint<double>& to) { return c.append_step(to, 1s); }},
                      Append{"Quintic", [](Course& c, const Waypoint<double>& to) { return c.append_quintic(to, 1s); }},
                      Append{"QuinticByLimits",
                             [](Course& c, const Waypoint<double>& to) { return c.append_quintic(to, SpeedLimits{}); }},
                      Append{"MinimumSnap",
                             [](Course& c, const Waypoint<double>& to) {
                               return c.append_minimum_snap(std::vector{place(0.5), to}, {});
                             }},
                      Append{"Timed",
                             [](Course& c, const Waypoint<double>& to) {
                               return c.append_timed(std::vector{TimedWaypoint<double>{place(0.5), 1s}, {to, 3s}});
                             }},
                      Append{"Polynomial",
                             [](Course& c, const Waypoint<double>& to) {
                               std::array<Polynomial<double>, kDimensions> axes{};
                               axes[0].c[1] = to.position_w_m.x();  // a line from 0 to there
                               axes[1].c[0] = to.position_w_m.y();
                               axes[2].c[0] = to.position_w_m.z();
                               axes[3].c[0] = to.yaw_rad;
                               return c.append_polynomial(axes, 1s);
                             }}),
    [](const auto& tested) { return tested.param.name; });

TEST_P(RefusedPlace, IsFarAwayOrNoNumberOnAnyAxis) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const auto said = [](const Waypoint<double>& to) {
    const auto course = standing();
    const Status status = GetParam().with_place(*course, to);
    EXPECT_EQ(course->end().position_w_m.x(), status == Status::kOk ? to.position_w_m.x() : 1.0)
        << "what is refused changes nothing";
    return status;
  };
  for (const double far_m : {1000.0, -1000.0}) {
    EXPECT_EQ(said(place(far_m, far_m, far_m, far_m / 10.0)), Status::kOk);
  }
  for (const double bad : {1000.01, -1000.01, none}) {
    EXPECT_EQ(said(place(bad)), Status::kOutOfRange);
    EXPECT_EQ(said(place(0.0, bad)), Status::kOutOfRange);
    EXPECT_EQ(said(place(0.0, 0.0, bad)), Status::kOutOfRange);
    EXPECT_EQ(said(place(0.0, 0.0, 1.0, bad / 10.0)), Status::kOutOfRange);
  }
}

TEST(RefusedTime, IsNoneOrNotApart) {
  const auto course = standing();
  for (const core::Duration none : {core::Duration(0), core::Duration(-1)}) {
    EXPECT_EQ(course->append_step(place(0.0), none), Status::kOutOfRange);
    EXPECT_EQ(course->append_quintic(place(0.0), none), Status::kOutOfRange);
    EXPECT_EQ(course->append_polynomial({}, none), Status::kOutOfRange);
    EXPECT_EQ(course->append_square(1.0, none, 0us), Status::kOutOfRange);
  }
  const auto timed = [&](core::Duration first, core::Duration second) {
    return standing()->append_timed(std::vector{TimedWaypoint<double>{place(0.0), first}, {place(1.0), second}});
  };
  EXPECT_EQ(timed(50ms, 100ms), Status::kOk);
  EXPECT_EQ(timed(50ms - 1us, 100ms), Status::kInvalidArgument);
  EXPECT_EQ(timed(50ms, 100ms - 1us), Status::kInvalidArgument);
  EXPECT_EQ(timed(1s, 1s + 1h), Status::kOk);
  EXPECT_EQ(timed(1s, 1s + 1h + 1us), Status::kInvalidArgument);
  EXPECT_EQ(standing()->append_timed({}), Status::kInvalidArgument);
  EXPECT_EQ(standing()->append_minimum_snap({}, {}), Status::kInvalidArgument);
  EXPECT_EQ(standing()->append_minimum_snap(std::vector{place(2.0)}, {.speed_m_s = 0.0}), Status::kInvalidArgument);
  EXPECT_EQ(course->pieces(), 0U);
}

TEST(RefusedLength, IsWhatFindsNoRoom) {
  const std::vector<Waypoint<double>> many(Course::kMaxWaypoints + 1, place(2.0));
  EXPECT_EQ(standing()->append_minimum_snap(many, {}), Status::kResourceExhausted);
  std::vector<TimedWaypoint<double>> timed;
  for (std::size_t i = 0; i <= Course::kMaxWaypoints; ++i) {
    timed.push_back({place(1.0 + 0.1 * static_cast<double>(i % 2)), (i + 1) * 100ms});
  }
  EXPECT_EQ(standing()->append_timed(timed), Status::kResourceExhausted);
  timed.pop_back();
  EXPECT_EQ(standing()->append_timed(timed), Status::kOk);
  // A course with room for one more piece, but not for two.
  const auto course = standing();
  for (std::size_t i = 0; i + 1 < Course::kMaxPieces; ++i) {
    ASSERT_EQ(course->append_step(place(1.0), 1s), Status::kOk) << i;
  }
  const std::vector<Waypoint<double>> two{place(1.0), place(2.0)};
  EXPECT_EQ(course->append_minimum_snap(two, {}), Status::kResourceExhausted);
  EXPECT_EQ(course->append_timed(std::vector{TimedWaypoint<double>{two[0], 1s}, {two[1], 2s}}),
            Status::kResourceExhausted);
  EXPECT_EQ(course->append_curve(Curve::circle(1.0, 1.0, 1.0), {}), Status::kResourceExhausted);
  EXPECT_EQ(course->append_square(1.0, 1s, 0us), Status::kResourceExhausted) << "its first side found room";
  EXPECT_EQ(course->pieces(), Course::kMaxPieces);
  EXPECT_EQ(course->append_step(place(1.0), 1s), Status::kResourceExhausted);
  EXPECT_EQ(course->append_polynomial({}, 1s), Status::kResourceExhausted);
}

// A curve keeps the tighter of the limits of tilt and acceleration; half of the acceleration is reserved for the ramp.
TEST(CurveLimits, TheTighterOfTiltAndAccelerationCounts) {
  const auto length = [](double acceleration_m_s2, double tilt_rad) {
    const auto course = standing();
    EXPECT_EQ(course->append_curve(Curve::circle(2.0, 2.0, 2.0),
                                   {.acceleration_m_s2 = acceleration_m_s2, .tilt_rad = tilt_rad}),
              Status::kOk);
    return course->duration();
  };
  const double tilt_of_one_rad = std::atan(1.0 / 9.80665);
  EXPECT_NEAR(core::seconds<double>(length(9.0, tilt_of_one_rad)), core::seconds<double>(length(1.0, 1.2)), 1e-3);
  EXPECT_GT(length(1.0, 1.2), length(2.0, 1.2));
}

}  // namespace
}  // namespace m100::ref::refusals
