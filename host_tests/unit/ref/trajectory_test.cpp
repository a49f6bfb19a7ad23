// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ref/trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "firmware/ref/minimum_snap.h"

namespace m100::ref {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

Waypoint<double> at(double x, double y, double z, double yaw = 0.0) {
  return {.position_w_m = {x, y, z}, .yaw_rad = yaw};
}

core::TimePoint time_of(double s) { return core::TimePoint(core::Duration(std::llround(s * 1e6))); }

// The optimum for one inner point in the middle of a straight line is known: by symmetry it passes the point without
// acceleration, at 35/16 of the mean speed (the rest-to-rest polynomial of degree 7 over the whole way).
TEST(MinimumSnap, MiddlePointOfAStraightLineMovesAsTheSinglePolynomialDoes) {
  std::array<Node, 3> nodes{};
  nodes[1].position[0] = 1.0;
  nodes[2].position[0] = 2.0;
  const std::array<double, 2> times{1.0, 1.0};
  minimise_snap(nodes, times);
  EXPECT_NEAR(nodes[1].velocity[0], 35.0 / 16.0, 1e-12);
  EXPECT_NEAR(nodes[1].acceleration[0], 0.0, 1e-12);
  EXPECT_NEAR(nodes[1].jerk[0], -13.125, 1e-10);  // 2 (140 s^3 (1 - s)^3)'' / 2^3 at s = 1/2: -52.5 / 4
}

double snap_cost(std::span<const Node> nodes, std::span<const double> times) {
  double cost = 0.0;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const double t = times[i];
    const Polynomial<double> p =
        through({.start = {nodes[i].position[0], nodes[i].velocity[0] * t, nodes[i].acceleration[0] * t * t,
                           nodes[i].jerk[0] * t * t * t},
                 .end = {nodes[i + 1].position[0], nodes[i + 1].velocity[0] * t, nodes[i + 1].acceleration[0] * t * t,
                         nodes[i + 1].jerk[0] * t * t * t}});
    for (int k = 0; k < 2000; ++k) {
      const double s = (k + 0.5) / 2000.0;
      const double snap = 24.0 * p.c[4] + 120.0 * p.c[5] * s + 360.0 * p.c[6] * s * s + 840.0 * p.c[7] * s * s * s;
      cost += snap * snap / 2000.0 / std::pow(t, 7.0);
    }
  }
  return cost;
}

// Catches a wrong block of the tridiagonal system: at the optimum every change of a free derivative raises the cost.
TEST(MinimumSnap, NoSmallChangeOfAnInnerDerivativeIsCheaper) {
  std::array<Node, 5> nodes{};
  const std::array<double, 5> x{0.0, 1.0, -0.5, 2.0, 1.5};
  for (std::size_t i = 0; i < 5; ++i) {
    nodes[i].position[0] = x[i];
  }
  const std::array<double, 4> times{1.0, 1.4, 2.0, 0.8};
  minimise_snap(nodes, times);
  const double least = snap_cost(nodes, times);
  for (std::size_t i = 1; i < 4; ++i) {
    for (const double change : {0.05, -0.05}) {
      for (auto member : {&Node::velocity, &Node::acceleration, &Node::jerk}) {
        std::array<Node, 5> other = nodes;
        (other[i].*member)[0] += change;
        EXPECT_GT(snap_cost(other, times), least);
      }
    }
  }
}

TEST(Trajectory, MinimumSnapPassesItsWaypointsInsideItsLimits) {
  Trajectory<double> course;
  course.hold(at(0, 0, 1));
  const std::array<Waypoint<double>, 5> way{at(2, 0, 1.5, 0.5), at(2, 2, 1), at(0, 2, 1.2, 3.0), at(-1, 0, 1, -3.0),
                                            at(0, 0, 1)};
  const SpeedLimits limits{.speed_m_s = 1.2, .acceleration_m_s2 = 1.5, .yaw_rate_rad_s = 0.8};
  ASSERT_EQ(course.append_minimum_snap(way, limits), core::Status::kOk);
  course.start(core::TimePoint{});
  const double total_s = core::seconds<double>(course.duration());
  std::array<double, 5> nearest;
  nearest.fill(1e9);
  double fastest = 0.0, strongest = 0.0, turning = 0.0;
  Window<double> before = course.window(time_of(0.0), core::Duration(0));
  for (double t = 0.0; t <= total_s; t += 0.002) {
    const Window<double> w = course.window(time_of(t), core::Duration(0));
    const core::Vector<double, 3> p{w.x[0].position_m, w.y[0].position_m, w.height.position_m};
    for (std::size_t i = 0; i < way.size(); ++i) {
      nearest[i] = std::min(nearest[i], (p - way[i].position_w_m).norm());
    }
    fastest = std::max(fastest, std::hypot(w.x[0].velocity_m_s, w.y[0].velocity_m_s, w.height.velocity_m_s));
    strongest =
        std::max(strongest, std::hypot(w.x[0].acceleration_m_s2, w.y[0].acceleration_m_s2, w.height.acceleration_m_s2));
    turning = std::max(turning, std::abs(w.yaw_rate_rad_s));
    EXPECT_NEAR(w.x[0].acceleration_m_s2, before.x[0].acceleration_m_s2, 0.05);  // continuous, without jumps
    before = w;
  }
  for (const double distance : nearest) {
    EXPECT_LE(distance, 0.003);  // sampled every 2 ms at 1.2 m/s or less
  }
  EXPECT_LE(fastest, limits.speed_m_s * 1.01);  // peaks are searched at 32 points per piece
  EXPECT_LE(strongest, limits.acceleration_m_s2 * 1.01);
  EXPECT_LE(turning, limits.yaw_rate_rad_s * 1.01);
  EXPECT_GE(
      std::max({fastest / limits.speed_m_s, strongest / limits.acceleration_m_s2, turning / limits.yaw_rate_rad_s}),
      0.98);  // and one limit is reached
}

// In ticks without a fresh pose the course waits before its next piece, and then continues with all of it.
TEST(Trajectory, APostponedStepBeginsAfterwards) {
  RecordProperty("promise", "R16");
  Trajectory<double> course;
  course.hold(at(0, 0, 1));
  ASSERT_EQ(course.append_step(at(0, 0, 1), milliseconds(1000)), core::Status::kOk);
  ASSERT_EQ(course.append_step(at(3, 0, 1), milliseconds(500)), core::Status::kOk);
  ASSERT_EQ(course.append_quintic(at(4, 0, 1), milliseconds(1000)), core::Status::kOk);
  course.start(core::TimePoint{});
  const auto x_at = [&](double t_s) { return course.window(time_of(t_s), core::Duration(0)).x[0].position_m; };
  course.postpone(time_of(0.5), milliseconds(10));
  EXPECT_EQ(course.duration(), milliseconds(2500));
  EXPECT_EQ(x_at(1.0), 3.0) << "nothing would have begun";
  course.postpone(time_of(1.3), milliseconds(470));  // a stall
  for (double t_s = 1.31; t_s < 2.0; t_s += 0.01) {
    course.postpone(time_of(t_s), milliseconds(10));
    EXPECT_EQ(x_at(t_s), 0.0) << t_s;
  }
  EXPECT_EQ(x_at(2.1), 3.0);
  EXPECT_EQ(x_at(2.4), 3.0);
  EXPECT_GT(x_at(2.9), 3.01) << "the ramp from rest begins half a second after the step";
  course.postpone(time_of(3.0), milliseconds(10));
  EXPECT_GT(x_at(3.1), 3.1) << "a motion goes on";
  EXPECT_FALSE(course.finished(time_of(3.4)));
  EXPECT_TRUE(course.finished(time_of(3.6)));
}

TEST(Trajectory, AMotionThatGoesOnIsNotPostponed) {
  Trajectory<double> course;
  course.hold(at(0, 0, 1));
  const std::array<Waypoint<double>, 2> way{at(2, 0, 1), at(2, 2, 1)};
  ASSERT_EQ(course.append_minimum_snap(way, {}), core::Status::kOk);
  course.start(core::TimePoint{});
  ASSERT_GT(course.pieces(), 1U);
  const double joint_s = core::seconds<double>(course.piece_end(0));
  course.postpone(time_of(joint_s + 0.005), milliseconds(10));
  EXPECT_TRUE(course.finished(core::TimePoint(course.duration())));
}

TEST(Trajectory, VelocityAndAccelerationAreTheDerivativesOfPosition) {
  Trajectory<double> course;
  course.hold(at(0, 0, 1));
  ASSERT_EQ(course.append_quintic(at(1, -2, 2, 1.0), milliseconds(2500)), core::Status::kOk);
  const double h = 1e-4;
  for (double t = 0.1; t < 2.4; t += 0.1) {
    const auto p = [&](double s) { return course.window(time_of(s), core::Duration(0)); };
    const double slope = (p(t + h).y[0].position_m - p(t - h).y[0].position_m) / (2 * h);
    const double bend = (p(t + h).y[0].velocity_m_s - p(t - h).y[0].velocity_m_s) / (2 * h);
    EXPECT_NEAR(p(t).y[0].velocity_m_s, slope, 1e-5);
    EXPECT_NEAR(p(t).y[0].acceleration_m_s2, bend, 1e-5);
  }
}

TEST(Trajectory, TheWindowLooksAheadByTheLeadAndTenthsOfSeconds) {
  Trajectory<double> course;
  course.hold(at(0, 0, 1));
  ASSERT_EQ(course.append_quintic(at(4, 0, 1), milliseconds(4000)), core::Status::kOk);
  const Window<double> shifted = course.window(time_of(1.0), milliseconds(107));
  for (std::size_t k = 0; k <= kHorizon; ++k) {
    const double t = 1.107 + 0.1 * static_cast<double>(k);
    EXPECT_NEAR(shifted.x[k].position_m, course.window(time_of(t), core::Duration(0)).x[0].position_m, 1e-9) << k;
  }
  EXPECT_FALSE(shifted.constant);
}

// Catches a preview in which the vehicle leans before a step that cannot be known in advance.
TEST(Trajectory, AStepIsNotSeenBeforeItComesAndFillsTheWindowAtOnce) {
  Trajectory<double> course;
  course.hold(at(0, 0, 1));
  ASSERT_EQ(course.append_step(at(0, 0, 1), seconds(5)), core::Status::kOk);
  ASSERT_EQ(course.append_step(at(6, 0, 1), seconds(5)), core::Status::kOk);
  const Window<double> before = course.window(time_of(4.99), milliseconds(33));
  EXPECT_TRUE(before.constant);
  EXPECT_EQ(before.x[kHorizon].position_m, 0.0);
  const Window<double> after = course.window(time_of(5.0), milliseconds(33));
  EXPECT_TRUE(after.constant);
  EXPECT_EQ(after.x[0].position_m, 6.0);
  EXPECT_EQ(course.window(time_of(60.0), core::Duration(0)).x[0].position_m, 6.0);
}

TEST(Trajectory, ASetPointBeforeACourseIsConstantOnlyWhileTheCourseIsOutOfSight) {
  Trajectory<double> course;
  course.hold(at(0, 0, 1));
  ASSERT_EQ(course.append_step(at(0, 0, 1), seconds(5)), core::Status::kOk);
  ASSERT_EQ(course.append_quintic(at(1, 0, 1), seconds(2)), core::Status::kOk);
  EXPECT_TRUE(course.window(time_of(2.0), core::Duration(0)).constant);
  EXPECT_FALSE(course.window(time_of(4.0), core::Duration(0)).constant);
  EXPECT_GT(course.window(time_of(4.0), core::Duration(0)).x[kHorizon].position_m, 0.4);
}

// Catches a short window that treats the reference after its last point as constant, or that shifts height and heading.
TEST(Trajectory, AWindowOfOnePointIsTheFirstOfTheWholeOneAndKnowsWhatIsBehindIt) {
  Trajectory<double> course;
  course.hold(at(0, 0, 1));
  ASSERT_EQ(course.append_step(at(0, 0, 1), seconds(5)), core::Status::kOk);
  ASSERT_EQ(course.append_quintic(at(1, 2, 3), seconds(2)), core::Status::kOk);
  for (const double t : {0.0, 2.95, 3.05, 4.0, 5.3, 6.5, 7.0, 9.0}) {
    SCOPED_TRACE(t);
    const Window<double> whole = course.window(time_of(t), milliseconds(33));
    Window<double> first = course.window(time_of(0.0), core::Duration(0));
    const double last_m = first.x[kHorizon].position_m;
    course.fill(first, time_of(t), milliseconds(33), 1);
    EXPECT_EQ(first.x[0].position_m, whole.x[0].position_m);
    EXPECT_EQ(first.y[0].velocity_m_s, whole.y[0].velocity_m_s);
    EXPECT_EQ(first.height.position_m, whole.height.position_m);
    EXPECT_EQ(first.yaw_rad, whole.yaw_rad);
    EXPECT_EQ(first.constant, whole.constant);
    EXPECT_EQ(first.x[kHorizon].position_m, last_m);
  }
}

TEST(Trajectory, TheSquareOfThePaperReturnsToItsCorner) {
  RecordProperty("paper", "IV-C.4");
  Trajectory<double> course;
  course.hold(at(0.5, 0.5, 1));
  ASSERT_EQ(course.append_square(1.0, seconds(3), seconds(1)), core::Status::kOk);
  EXPECT_EQ(course.duration(), seconds(16));
  const auto p = [&](double t) { return course.window(time_of(t), core::Duration(0)); };
  EXPECT_NEAR(p(3.5).x[0].position_m, 1.5, 1e-12);
  EXPECT_NEAR(p(7.5).y[0].position_m, 1.5, 1e-12);
  EXPECT_NEAR(p(11.5).x[0].position_m, 0.5, 1e-12);
  EXPECT_NEAR(p(20.0).y[0].position_m, 0.5, 1e-12);
  EXPECT_TRUE(p(20.0).constant);
}

}  // namespace
}  // namespace m100::ref
