// SPDX-License-Identifier: BSD-3-Clause
// Jumps that a pose source announces: what moves, and what must not.
#include "firmware/app/source_frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace m100::app {
namespace {

using std::chrono::milliseconds;
using Vector = core::Vector<double, 3>;

/// An aircraft that flies straight through the flight's world, seen from a source's world.
struct SourceFrameTest : ::testing::Test {
  SourceFrame<double> frame;
  core::TimePoint now{std::chrono::seconds(10)};
  est::Estimate<double> estimate;
  Vector shift_m = Vector::Zero();  ///< of the source's world
  double turn_rad = 0.0;
  std::uint32_t announced = 0;
  static constexpr core::Duration kLatency = milliseconds(30);

  SourceFrameTest() {
    estimate.healthy = estimate.prediction_valid = true;
    estimate.x = {.position_m = 2.0, .velocity_m_s = 0.8};
    estimate.y = {.position_m = -1.0, .velocity_m_s = -0.4};
    estimate.height_m = 1.5;
    estimate.yaw_rad = 0.6;
  }
  /// The pose 20 ms before the estimate of the tick before. @param seen_m what the pose shows beyond that
  /// @returns how far it is from what it shows, in the flight's world.
  double after(core::Duration time, double seen_m = 0.0) {
    now += time;
    const Vector true_m(2.0 - 0.02 * 0.8 + seen_m, -1.0 + 0.02 * 0.4, 1.5);
    core::Pose<double> pose;
    pose.is_new = true;
    const core::Vector<double, 2> turned = core::rotate_by_yaw<double>({true_m.x(), true_m.y()}, turn_rad);
    pose.position_w_m = Vector(turned.x(), turned.y(), true_m.z()) + shift_m;
    pose.yaw_rad = core::wrap_pi(0.6 + turn_rad);
    moved = frame.update(pose, announced, estimate, kLatency, now);
    yaw_rad = pose.yaw_rad;
    return (pose.position_w_m - true_m).norm();
  }
  bool moved = false;
  double yaw_rad = 0.0;
};

TEST_F(SourceFrameTest, AnAnnouncedJumpLeavesThePoseWhereThePredictionIs) {
  EXPECT_EQ(after(milliseconds(10)), 0.0);
  shift_m = {0.5, -0.2, 0.1};
  EXPECT_GT(after(milliseconds(10)), 0.5) << "not announced";
  EXPECT_FALSE(moved);
  announced = 1;
  EXPECT_LT(after(milliseconds(10)), 1e-9);
  EXPECT_TRUE(moved);
  EXPECT_NEAR(frame.jump().by_m[0], 0.5, 1e-9);
  EXPECT_NEAR(frame.jump().by_m[1], -0.2, 1e-9);
  EXPECT_EQ(frame.jump().turned_rad, 0.0);
  EXPECT_NEAR((frame.to_source(Vector(1.0, 2.0, 3.0)) - Vector(1.5, 1.8, 3.1)).norm(), 0.0, 1e-9);
  shift_m.z() += 0.3;
  EXPECT_NEAR(after(milliseconds(300)), 0.3, 1e-9) << "the next is not announced";
}

TEST_F(SourceFrameTest, ATurnOfTheHeadingIsTakenAlong) {
  for (const double step_rad : {0.3, -2.0, 3.0}) {
    turn_rad += step_rad;
    shift_m += Vector(0.1, 0.7, 0.0);
    ++announced;
    EXPECT_LT(after(milliseconds(400)), 1e-9);
    EXPECT_NEAR(yaw_rad, 0.6, 1e-9);
    EXPECT_NEAR(core::wrap_pi(frame.jump().turned_rad - step_rad), 0.0, 1e-9);
    EXPECT_LT(after(milliseconds(10)), 1e-9) << "and so are the poses after it";
    const Vector place_m(0.3, 4.0, 1.0);
    EXPECT_NEAR((frame.to_flight(frame.to_source(place_m)) - place_m).norm(), 0.0, 1e-9);
  }
}

// Catches a source that hides a false motion behind a counter that rises with every pose.
TEST_F(SourceFrameTest, AnAnnouncementCountsOnlyAfterPosesHaveFollowedThePrediction) {
  announced = 1;
  (void)after(milliseconds(10));
  ASSERT_TRUE(moved);
  for (int i = 1; i <= 29; ++i) {
    ++announced;
    EXPECT_NEAR(after(milliseconds(10), 0.01 * i), 0.0, 1e-9) << "the motion is shown";
    EXPECT_FALSE(moved) << i;
  }
  estimate.refused_poses = 1;
  ++announced;
  (void)after(milliseconds(400), 1.0);
  EXPECT_FALSE(moved) << "the poses before were refused";
  estimate.refused_poses = 0;
  (void)after(milliseconds(10), 1.0);
  EXPECT_FALSE(moved) << "an announcement is of one pose";
  estimate.prediction_valid = false;
  ++announced;
  (void)after(milliseconds(400), 1.0);
  EXPECT_FALSE(moved) << "nothing is predicted";
}

// Catches a box that is turned into one that reaches beyond, and one that walks with the source's world.
TEST_F(SourceFrameTest, TheMovedFenceLiesInsideTheSourcesFence) {
  const core::Fence fence{.side = {{{-3.0, 5.0}, {-6.0, 6.0}, {0.3, 4.0}}}};
  for (const double turned_rad : {0.0, 0.3, -1.2, 1.5708, 3.0}) {
    turn_rad += turned_rad;
    shift_m += Vector(0.4, -0.1, 0.05);
    ++announced;
    (void)after(milliseconds(400));
    const core::Fence box = frame.moved(fence);
    double nearest_m = 1e9;
    for (const double x : {box.side[0].low_m, box.side[0].high_m}) {
      for (const double y : {box.side[1].low_m, box.side[1].high_m}) {
        const Vector corner_m = frame.to_source({x, y, box.side[2].low_m});
        nearest_m =
            std::min({nearest_m, corner_m.x() + 3.0, 5.0 - corner_m.x(), corner_m.y() + 6.0, 6.0 - corner_m.y()});
        EXPECT_NEAR(corner_m.z(), 0.3, 1e-9);
      }
    }
    EXPECT_NEAR(nearest_m, 0.0, 1e-6) << "it touches a side, and lies beyond none";
  }
}

}  // namespace
}  // namespace m100::app
