// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/start_position.h"

#include <gtest/gtest.h>

#include <random>

namespace m100::companion {
namespace {

core::Pose<double> at(double x, double y, double z, double yaw_rad = 0.0) {
  core::Pose<double> pose;
  pose.position_w_m = {x, y, z};
  pose.yaw_rad = yaw_rad;
  return pose;
}

// Catches a course and a fence that are laid from one wrong pose: a pose 1.2 m off moved both by 1.2 m, without a
// message.
TEST(StartPosition, IsNotTheFirstPoseWhereTheOthersContradictIt) {
  StartPosition place;
  EXPECT_FALSE(place.add(at(1.2, 0.0, 1.5, 2.0)));
  for (int k = 0; k < 7; ++k) {
    EXPECT_FALSE(place.add(at(0.001 * k, 0.0, 1.5, 0.3)));
  }
  const auto start = place.add(at(0.0, 0.0, 1.5, 0.3));
  ASSERT_TRUE(start);
  EXPECT_NEAR(start->position_w_m.x(), 0.0, 0.01);
  EXPECT_EQ(start->yaw_rad, 0.3);
}

// Catches a course that gets the heading of one wrong pose because the position of that pose was the best.
TEST(StartPosition, ItsHeadingIsOneThatTheOthersHave) {
  for (const double heading_rad : {0.3, 3.1415}) {  // the second near the wrap
    StartPosition place;
    for (int k = 0; k < 8; ++k) {
      const double yaw_rad = core::wrap_pi(heading_rad + 0.01 * (k - 4));
      EXPECT_FALSE(place.add(k == 4 ? at(0.0, 0.0, 1.5, heading_rad - 1.6) : at(0.01 * (k - 4), 0.0, 1.5, yaw_rad)));
    }
    const auto start = place.add(at(0.04, 0.0, 1.5, heading_rad));
    ASSERT_TRUE(start);
    EXPECT_NEAR(core::wrap_pi(start->yaw_rad - heading_rad), 0.0, 0.05);
    EXPECT_NEAR(start->position_w_m.x(), 0.0, 0.02);
  }
}

TEST(StartPosition, IsFoundAmongOutliersOfMetres) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.002);
  std::bernoulli_distribution spoilt(0.05);
  for (int flight = 0; flight < 200; ++flight) {
    StartPosition place;
    std::optional<ref::Waypoint<double>> start;
    while (!start) {
      start = place.add(at((spoilt(random) ? 3.0 : 0.0) + noise(random), 1.0 + noise(random), 1.5));
    }
    EXPECT_NEAR(start->position_w_m.x(), 0.0, 0.02);
    EXPECT_NEAR(start->position_w_m.y(), 1.0, 0.02);
  }
}

TEST(StartPosition, IsNoneWhereNothingAgrees) {
  StartPosition place;
  for (int k = 0; k < 100; ++k) {
    EXPECT_FALSE(place.add(at(2.0 * (k % 5), 0.0, 1.5)));
  }
  EXPECT_TRUE(place.disagrees());
}

}  // namespace
}  // namespace m100::companion
