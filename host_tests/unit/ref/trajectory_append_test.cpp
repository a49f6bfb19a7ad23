// SPDX-License-Identifier: BSD-3-Clause
// Ways through points and along curves: where they pass, and how smooth they are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "firmware/model/vehicle.h"
#include "firmware/ref/trajectory.h"

namespace m100::ref {
namespace {

using std::chrono::milliseconds;

Waypoint<double> at(double x, double y, double z, double yaw = 0.0) {
  return {.position_w_m = {x, y, z}, .yaw_rad = yaw};
}

/// The largest jump of a derivative at the joints of the pieces, relative to its largest value anywhere.
double worst_jump(const Trajectory<double>& course, std::size_t axis, std::size_t order, bool ends_too) {
  double jump = 0.0, largest = 1e-9;
  for (std::size_t piece = 0; piece + (ends_too ? 0 : 1) < course.pieces(); ++piece) {
    const core::Duration joint = course.piece_end(piece);
    jump = std::max(jump, std::abs(course.motion(joint)[axis][order] - course.motion(joint, true)[axis][order]));
  }
  if (ends_too && order > 0) {
    jump = std::max(jump, std::abs(course.motion(core::Duration{0})[axis][order]));
  }
  for (core::Duration t{0}; t < course.duration(); t += milliseconds(5)) {
    largest = std::max(largest, std::abs(course.motion(t)[axis][order]));
  }
  return jump / largest;
}

/// Ten random courses of 2 to 9 points inside a room; neighbours are at least 0.2 m apart.
class RandomWay : public ::testing::TestWithParam<unsigned> {
 protected:
  RandomWay() : random_(GetParam()) {
    course_->hold(at(0, 0, 1));
    const auto count = std::uniform_int_distribution<std::size_t>(2, 9)(random_);
    Waypoint<double> last = at(0, 0, 1);
    while (points_.size() < count) {
      const Waypoint<double> next = at(between(-4, 4), between(-4, 4), between(0.5, 3), between(-3, 3));
      if ((next.position_w_m - last.position_w_m).norm() > 0.2) {
        points_.push_back(next);
        last = next;
      }
    }
  }
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  std::mt19937 random_;
  std::vector<Waypoint<double>> points_;
  std::unique_ptr<Trajectory<double>> course_ = std::make_unique<Trajectory<double>>();
};
INSTANTIATE_TEST_SUITE_P(Seeds, RandomWay, ::testing::Range(1U, 11U));

// With minimum snap the fourth derivative is continuous at every waypoint. This is the condition of the optimum, so a
// wrong elimination shows here. Tolerance 1e-6, because the blocks hold the seventh power of times.
TEST_P(RandomWay, OfLeastSnapPassesItsPointsAndIsContinuousToTheFourthDerivative) {
  const SpeedLimits limits{.speed_m_s = 2.0, .acceleration_m_s2 = 3.0, .yaw_rate_rad_s = 1.0, .tilt_rad = 0.2};
  ASSERT_EQ(course_->append_minimum_snap(std::span<const Waypoint<double>>(points_), limits), core::Status::kOk);
  ASSERT_EQ(course_->pieces(), points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Motion there = course_->motion(course_->piece_end(i), true);
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_NEAR(there[d][0], points_[i].position_w_m[static_cast<Eigen::Index>(d)], 1e-9) << "point " << i;
    }
    EXPECT_NEAR(std::remainder(there[3][0] - points_[i].yaw_rad, 2.0 * std::numbers::pi), 0.0, 1e-9);
  }
  for (std::size_t axis = 0; axis < kDimensions; ++axis) {
    for (std::size_t order = 0; order <= 4; ++order) {
      EXPECT_LE(worst_jump(*course_, axis, order, order < 4), 1e-6) << "axis " << axis << " derivative " << order;
    }
  }
}

// Tilt is an angle: the acceleration at 0.2 rad is g tan(0.2), not 0.2 g. One limit must be reached, none exceeded.
// Tolerance 1 %, because peaks are searched at 32 points per piece.
TEST_P(RandomWay, KeepsItsLimitsAndUsesOneUp) {
  const SpeedLimits limits{.speed_m_s = 6.0, .acceleration_m_s2 = 9.0, .yaw_rate_rad_s = 6.0, .tilt_rad = 0.2};
  ASSERT_EQ(course_->append_minimum_snap(std::span<const Waypoint<double>>(points_), limits), core::Status::kOk);
  double used = 0.0;
  for (core::Duration t{0}; t < course_->duration(); t += milliseconds(2)) {
    const Motion m = course_->motion(t);
    const double tilt = std::atan2(std::hypot(m[0][2], m[1][2]), model::kGravity_m_s2 + m[2][2]);
    EXPECT_NEAR(tilt_of(m[0][2], m[1][2], m[2][2]), tilt, 1e-12);
    used = std::max({used, tilt / limits.tilt_rad, std::hypot(m[0][1], m[1][1], m[2][1]) / limits.speed_m_s,
                     std::hypot(m[0][2], m[1][2], m[2][2]) / limits.acceleration_m_s2,
                     std::abs(m[3][1]) / limits.yaw_rate_rad_s});
  }
  EXPECT_LE(used, 1.01);
  EXPECT_GE(used, 0.98);
}

// Times with ratios of up to 1 to 20; the blocks then differ by 20^7.
TEST_P(RandomWay, ByTheClockIsAtItsPointsInTime) {
  std::vector<TimedWaypoint<double>> timed;
  core::Duration when{0};
  for (const Waypoint<double>& point : points_) {
    when += core::Duration(std::llround(between(0.3, 6.0) * 1e6));
    timed.push_back({.place = point, .at = when});
  }
  ASSERT_EQ(course_->append_timed(std::span<const TimedWaypoint<double>>(timed)), core::Status::kOk);
  EXPECT_EQ(course_->duration(), when);
  for (const TimedWaypoint<double>& point : timed) {
    const Motion there = course_->motion(point.at, true);
    EXPECT_NEAR(there[0][0], point.place.position_w_m.x(), 1e-8);
    EXPECT_NEAR(there[1][0], point.place.position_w_m.y(), 1e-8);
  }
  for (std::size_t order = 0; order <= 4; ++order) {
    EXPECT_LE(worst_jump(*course_, 0, order, order < 4), 1e-6) << "derivative " << order;
  }
}

struct Round {
  const char* name;
  Curve curve;
};
void PrintTo(const Round& one, std::ostream* out) { *out << one.name; }
class CurveFlown : public ::testing::TestWithParam<Round> {};
INSTANTIATE_TEST_SUITE_P(Table, CurveFlown,
                         ::testing::Values(Round{"Circle", Curve::circle(2.0, 1.5, 2.0)},
                                           Round{"ClockwiseAndFast", Curve::circle(-1.0, 2.5, 3.0)},
                                           Round{"TooShortForItsSpeed", Curve::circle(1.0, 8.0, 0.5)},
                                           Round{"SmallAndSlow", Curve::circle(0.3, 0.1, 1.0)},
                                           Round{"Eight", Curve::figure_of_eight(4.0, 2.0, 1.5, 2.0)},
                                           Round{"SlenderEight", Curve::figure_of_eight(6.0, 0.5, 2.0, 1.0)}),
                         [](const auto& one) { return std::string(one.param.name); });

// The pieces are polynomials. Eight of them per turn reach 1e-6 of the size: the eighth derivative of the sine times
// (pi/4)^8 / (8! 2^8) is 1.4e-8, of the ramp 2e-7. The fourth derivative agrees to 1 % of its peak, because a piece
// matches three derivatives and the fourth is the remainder: (pi/4)^4 / 1680 = 2.3e-4, and 0.1 % in the ramp.
TEST_P(CurveFlown, KeepsItsShapeAndIsContinuousToTheFourthDerivative) {
  const Curve& curve = GetParam().curve;
  auto course = std::make_unique<Trajectory<double>>();
  course->hold(at(3, -2, 1.5, 0.4));
  const SpeedLimits limits{.speed_m_s = 100.0, .acceleration_m_s2 = 4.0};
  ASSERT_EQ(course->append_curve(curve, limits), core::Status::kOk);
  double fastest = 0.0;
  for (core::Duration t{0}; t <= course->duration(); t += milliseconds(3)) {
    const Motion m = course->motion(t, true);
    const double x = (m[0][0] - 3.0) / curve.a_m, y = (m[1][0] + 2.0) / curve.b_m;
    // The circle satisfies x^2 + (1 - y)^2 = 1, the figure of eight y^2 = 4 x^2 (1 - x^2).
    EXPECT_NEAR(curve.eight ? y * y - 4.0 * x * x * (1.0 - x * x) : x * x + (1.0 - y) * (1.0 - y) - 1.0, 0.0, 1e-5);
    EXPECT_EQ(m[2][0], 1.5);
    fastest = std::max(fastest, std::hypot(m[0][1], m[1][1]));
  }
  EXPECT_LE(fastest, curve.speed_m_s * 1.0001);
  if (GetParam().name != std::string("TooShortForItsSpeed")) {
    EXPECT_GE(fastest, curve.speed_m_s * 0.99);
  }
  for (const std::size_t axis : {0U, 1U}) {
    for (std::size_t order = 0; order <= 4; ++order) {
      EXPECT_LE(worst_jump(*course, axis, order, true), order < 4 ? 1e-6 : 0.01) << "derivative " << order;
    }
  }
  if (curve.turns == std::floor(curve.turns)) {
    EXPECT_NEAR(course->motion(course->duration())[0][0], 3.0, 1e-9);
    EXPECT_NEAR(course->motion(course->duration())[1][0], -2.0, 1e-9);
  }
}

TEST(CurveFlown, ThatIsTooLongForTheTableIsRefusedWhole) {
  auto course = std::make_unique<Trajectory<double>>();
  EXPECT_EQ(course->append_curve(Curve::circle(1.0, 1.0, 101.0), {}), core::Status::kOutOfRange);
  EXPECT_EQ(course->append_curve(Curve::figure_of_eight(2.0, 1.0, 1.0, 100.0), {}), core::Status::kResourceExhausted);
  EXPECT_EQ(course->pieces(), 0U);
}

// The tick finds its piece by bisection; with many pieces the window in the last one must equal that of the piece
// alone.
TEST(Trajectory, FindsThePieceOfATimeAmongMany) {
  auto course = std::make_unique<Trajectory<double>>();
  course->hold(at(0, 0, 1));
  for (int i = 1; i <= 300; ++i) {
    ASSERT_EQ(course->append_step(at(i, 0, 1), milliseconds(100 + i % 7)), core::Status::kOk);
  }
  course->start(core::TimePoint{});
  core::Duration begin{0};
  for (int i = 1; i <= 300; ++i) {
    for (const core::Duration inside :
         {core::Duration{0}, core::Duration{milliseconds(100 + i % 7)} - core::Duration{1}}) {
      EXPECT_EQ(course->window(core::TimePoint{} + begin + inside, core::Duration{0}).x[0].position_m, i);
    }
    begin += milliseconds(100 + i % 7);
  }
}

}  // namespace
}  // namespace m100::ref
