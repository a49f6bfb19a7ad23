// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/frames.h"

#include <gtest/gtest.h>

namespace m100::core {
namespace {

struct AxisCase {
  const char* name;
  Vector<double, 3> autopilot;  // NED or FRD
  Vector<double, 3> ours;       // NWU or FLU
};

class Flip : public ::testing::TestWithParam<AxisCase> {};

// Catches a frame conversion that turns about y or z, or mirrors one axis only.
TEST_P(Flip, TurnsByPiAboutX) {
  EXPECT_EQ(flip_yz(GetParam().autopilot), GetParam().ours);
  EXPECT_EQ(flip_yz(GetParam().ours), GetParam().autopilot);
}

INSTANTIATE_TEST_SUITE_P(
    SixAxes, Flip,
    ::testing::Values(AxisCase{"North", {1, 0, 0}, {1, 0, 0}}, AxisCase{"South", {-1, 0, 0}, {-1, 0, 0}},
                      AxisCase{"East", {0, 1, 0}, {0, -1, 0}}, AxisCase{"West", {0, -1, 0}, {0, 1, 0}},
                      AxisCase{"Down", {0, 0, 1}, {0, 0, -1}}, AxisCase{"Up", {0, 0, -1}, {0, 0, 1}}),
    [](const auto& tested) { return tested.param.name; });

TEST(Quaternion, EulerAnglesComeBack) {
  const Euler<double> e{.roll_rad = 0.3, .pitch_rad = -0.2, .yaw_rad = 2.5};
  const Euler<double> back = euler_of(quaternion_of(e));
  EXPECT_NEAR(back.roll_rad, e.roll_rad, 1e-12);
  EXPECT_NEAR(back.pitch_rad, e.pitch_rad, 1e-12);
  EXPECT_NEAR(back.yaw_rad, e.yaw_rad, 1e-12);
}

}  // namespace
}  // namespace m100::core
