// SPDX-License-Identifier: BSD-3-Clause
// Each limit of a trajectory at its last valid and first invalid number, and the durations of its pieces.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "firmware/ref/trajectory.h"

namespace m100::ref {
namespace {

using Course = Trajectory<double>;

Waypoint<double> at(double x_m, double y_m, double z_m, double yaw_rad = 0.0) {
  return {.position_w_m = {x_m, y_m, z_m}, .yaw_rad = yaw_rad};
}

std::unique_ptr<Course> standing() {
  auto course = std::make_unique<Course>();
  course->hold(at(0, 0, 1));
  return course;
}
bool goes_with(const SpeedLimits& limits) {
  return standing()->append_quintic(at(1, 0, 1), limits) == core::Status::kOk;
}
bool flies(const Curve& curve) { return standing()->append_curve(curve, {}) != core::Status::kOutOfRange; }

struct Edge {
  const char* name;
  bool (*takes)(double);
  double low, below;
  double high, above;
};
const Edge kEdges[] = {
    {"Speed", [](double v) { return goes_with({.speed_m_s = v}); }, 0.01, 0.0099, 100, 100.1},
    {"Acceleration", [](double v) { return goes_with({.acceleration_m_s2 = v}); }, 0.01, 0.0099, 100, 100.1},
    {"YawRate", [](double v) { return goes_with({.yaw_rate_rad_s = v}); }, 0.01, 0.0099, 100, 100.1},
    {"Tilt", [](double v) { return goes_with({.tilt_rad = v}); }, 0.01, 0.0099, 1.2, 1.21},
    {"Radius", [](double v) { return flies(Curve::circle(v, 1.0, 0.5)); }, 0.05, 0.0499, 500, 500.1},
    {"RadiusTheOtherWay", [](double v) { return flies(Curve::circle(-v, 1.0, 0.5)); }, 0.05, 0.0499, 500, 500.1},
    {"Length", [](double v) { return flies(Curve::figure_of_eight(v, 1.0, 1.0, 0.5)); }, 0.1, 0.0998, 1000, 1000.2},
    {"Width", [](double v) { return flies(Curve::figure_of_eight(1.0, v, 1.0, 0.5)); }, 0.1, 0.0998, 1000, 1000.2},
    {"CurveSpeed", [](double v) { return flies(Curve::circle(1.0, v, 0.5)); }, 0.01, 0.0099, 100, 100.1},
    {"Turns", [](double v) { return flies(Curve::circle(1.0, 1.0, v)); }, 0.0101, 0.01, 100, 100.1},
};

class RefLimit : public ::testing::TestWithParam<Edge> {};

TEST_P(RefLimit, TakesItsLastNumberAndNotTheNext) {
  const Edge& edge = GetParam();
  EXPECT_TRUE(edge.takes(edge.low)) << edge.low;
  EXPECT_FALSE(edge.takes(edge.below)) << edge.below;
  EXPECT_TRUE(edge.takes(edge.high)) << edge.high;
  EXPECT_FALSE(edge.takes(edge.above)) << edge.above;
}
INSTANTIATE_TEST_SUITE_P(Ref, RefLimit, ::testing::ValuesIn(kEdges),
                         [](const auto& tested) { return std::string(tested.param.name); });

double seconds_to(const Waypoint<double>& place, const SpeedLimits& limits) {
  const auto course = standing();
  EXPECT_EQ(course->append_quintic(place, limits), core::Status::kOk);
  return core::seconds<double>(course->duration());
}

// Peaks of the quintic: 15/8 of its mean speed; 10/sqrt(3) times the distance over the time squared.
TEST(Quintic, TakesAsLongAsItsTightestLimitAsks) {
  EXPECT_NEAR(seconds_to(at(3, 0, 1), {}), 1.875 * 3.0 / 1.5, 2e-6) << "speed";
  EXPECT_NEAR(seconds_to(at(0, 3, 5), {.speed_m_s = 100.0}), std::sqrt(10.0 / std::sqrt(3.0) * 5.0 / 2.0), 2e-6)
      << "acceleration, of the way in space";
  EXPECT_NEAR(seconds_to(at(0, 0, 1, 1.0), {}), 1.875 * 1.0 / 0.8, 2e-6) << "yaw";
  EXPECT_NEAR(seconds_to(at(0, 0, 1, -1.0), {}), 1.875 * 1.0 / 0.8, 2e-6) << "yaw the other way";
  EXPECT_NEAR(seconds_to(at(0, 0, 1, 6.0), {}), 1.875 * (2.0 * 3.14159265358979 - 6.0) / 0.8, 2e-6) << "the short way";
}

}  // namespace
}  // namespace m100::ref
