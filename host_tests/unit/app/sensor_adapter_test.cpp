// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/app/sensor_adapter.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>

#include "firmware/core/frames.h"

namespace m100::app {
namespace {

using std::chrono::milliseconds;
constexpr core::TimePoint kNow{std::chrono::seconds(5)};

protocol::Telemetry telemetry_of(const core::Euler<double>& flu, const std::array<float, 3>& rates_frd) {
  const core::Quaternion<double> q = core::flip_yz(core::quaternion_of(flu));
  protocol::Telemetry telemetry;
  telemetry.items = protocol::kAllTelemetryItems;
  telemetry.attitude = {static_cast<float>(q.w), static_cast<float>(q.x), static_cast<float>(q.y),
                        static_cast<float>(q.z)};
  telemetry.angular_velocity_frd_rad_s = rates_frd;
  return telemetry;
}

core::Pose<double> pose_at(core::TimePoint captured, const core::Vector<double, 3>& position_w_m,
                           double yaw_rad = 0.0) {
  core::Pose<double> pose;
  pose.is_new = true;
  pose.set_captured_at(captured);
  pose.position_w_m = position_w_m;
  pose.yaw_rad = yaw_rad;
  return pose;
}

TEST(SensorAdapter, TurnsTheAutopilotsFramesIntoOurs) {
  RecordProperty("paper", "III-A");
  SensorAdapter measure;
  const core::Euler<double> truth{.roll_rad = 0.1, .pitch_rad = -0.2, .yaw_rad = 1.0};
  const auto measured =
      measure.update<double>(telemetry_of(truth, {0.1F, 0.2F, 0.3F}), milliseconds(2), core::Pose<double>{}, kNow);
  ASSERT_TRUE(measured.attitude.is_new);
  EXPECT_NEAR(measured.attitude.roll_rad, 0.1, 1e-6);
  EXPECT_NEAR(measured.attitude.pitch_rad, -0.2, 1e-6);
  EXPECT_NEAR(measured.attitude.yaw_rad, 1.0, 1e-6);
  EXPECT_NEAR(measured.attitude.rate_b_rad_s.y(), -0.2, 1e-6);
  EXPECT_NEAR(measured.attitude.rate_b_rad_s.z(), -0.3, 1e-6);
  EXPECT_EQ(measured.attitude.age, milliseconds(2));
  EXPECT_FALSE(measured.pose.is_new);
}

TEST(SensorAdapter, SaysHowOldAPoseIs) {
  RecordProperty("promise", "R3");
  SensorAdapter measure;
  const core::Pose<double> pose = pose_at(kNow - milliseconds(23), {1.0, 2.0, 3.0});
  const auto measured = measure.update<float>(protocol::Telemetry{}, milliseconds(0), pose, kNow);
  ASSERT_TRUE(measured.pose.is_new);
  EXPECT_EQ(measured.pose.age(kNow), milliseconds(23));
  EXPECT_EQ(measured.pose.position_w_m.y(), 2.0F);
}

struct BadPose {
  const char* name;
  core::Pose<double> pose;
};
class RefusedPose : public ::testing::TestWithParam<BadPose> {};
TEST_P(RefusedPose, IsDroppedAndCounted) {
  SensorAdapter measure;
  const auto measured = measure.update<double>(protocol::Telemetry{}, milliseconds(0), GetParam().pose, kNow);
  EXPECT_FALSE(measured.pose.is_new);
  EXPECT_EQ(measure.stats().refused_poses, 1U);
}
INSTANTIATE_TEST_SUITE_P(
    Table, RefusedPose,
    ::testing::Values(BadPose{"NotANumber", pose_at(kNow, {std::nan(""), 0.0, 1.0}, 0.0)},
                      BadPose{"Infinite", pose_at(kNow, {0.0, -std::numeric_limits<double>::infinity(), 1.0}, 0.0)},
                      BadPose{"FarAway", pose_at(kNow, {0.0, 0.0, 1e6}, 0.0)},
                      BadPose{"YawNotANumber", pose_at(kNow, {0.0, 0.0, 1.0}, std::nan(""))},
                      BadPose{"FromTheFuture", pose_at(kNow + milliseconds(1), {0.0, 0.0, 1.0}, 0.0)}),
    [](const auto& tested) { return tested.param.name; });

struct BadAttitude {
  const char* name;
  void (*spoil)(protocol::Telemetry&);
};
class RefusedAttitude : public ::testing::TestWithParam<BadAttitude> {};
TEST_P(RefusedAttitude, IsDroppedAndCounted) {
  SensorAdapter measure;
  protocol::Telemetry telemetry = telemetry_of({}, {0.0F, 0.0F, 0.0F});
  GetParam().spoil(telemetry);
  EXPECT_FALSE(measure.update<double>(telemetry, milliseconds(0), core::Pose<double>{}, kNow).attitude.is_new);
  EXPECT_EQ(measure.stats().refused_attitudes, 1U);
}
INSTANTIATE_TEST_SUITE_P(
    Table, RefusedAttitude,
    ::testing::Values(BadAttitude{"NotANumber", [](protocol::Telemetry& bad) { bad.attitude[2] = std::nanf(""); }},
                      BadAttitude{"NotUnit", [](protocol::Telemetry& bad) { bad.attitude[0] = 0.9F; }},
                      BadAttitude{"RatesInDegrees",
                                  [](protocol::Telemetry& bad) {
                                    bad.angular_velocity_frd_rad_s = {57.3F, 0.F, 0.F};
                                  }},
                      BadAttitude{"OnItsSide",
                                  [](protocol::Telemetry& bad) {
                                    bad.attitude = {0.7071F, 0.7071F, 0, 0};
                                  }}),
    [](const auto& tested) { return tested.param.name; });

TEST(SensorAdapter, NoticesAStuckSensor) {
  SensorAdapter measure;
  const protocol::Telemetry telemetry = telemetry_of({.roll_rad = 0.01}, {0.01F, 0.0F, 0.0F});
  int used = 0;
  for (int i = 0; i < 100; ++i) {
    used += measure.update<double>(telemetry, milliseconds(0), core::Pose<double>{}, kNow).attitude.is_new ? 1 : 0;
  }
  EXPECT_EQ(used, 50);
}

// Motion capture that has lost the aircraft repeats the last pose with new time stamps.
TEST(SensorAdapter, TakesTheSamePoseAgainForNothingNew) {
  SensorAdapter measure;
  core::Pose<double> pose = pose_at(kNow, {1.0, 2.0, 3.0});
  EXPECT_TRUE(measure.update<double>({}, milliseconds(3), pose, kNow).pose.is_new);
  pose.set_captured_at(kNow + milliseconds(10));
  EXPECT_FALSE(measure.update<double>({}, milliseconds(3), pose, kNow + milliseconds(10)).pose.is_new);
  EXPECT_EQ(measure.stats().repeated_poses, 1U);
  pose.position_w_m.x() += 1e-9;
  EXPECT_TRUE(measure.update<double>({}, milliseconds(3), pose, kNow + milliseconds(10)).pose.is_new);
}

}  // namespace
}  // namespace m100::app
