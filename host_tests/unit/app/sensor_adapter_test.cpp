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

template <typename T = double>
est::Measurement<T> adapted(SensorAdapter& adapter, const protocol::Telemetry& telemetry,
                            const core::Pose<double>& pose = {}, core::TimePoint now = kNow) {
  return adapter.update<T>(telemetry, milliseconds(2), pose, {}, now);
}

TEST(SensorAdapter, SaysHowOldAPoseIs) {
  RecordProperty("promise", "R3");
  SensorAdapter measure;
  const core::Pose<double> pose = pose_at(kNow - milliseconds(23), {1.0, 2.0, 3.0});
  const auto measured = adapted<float>(measure, {}, pose);
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
  EXPECT_FALSE(adapted(measure, {}, GetParam().pose).pose.is_new);
  EXPECT_EQ(measure.stats().refused_poses, 1U);
}
INSTANTIATE_TEST_SUITE_P(
    Table, RefusedPose,
    ::testing::Values(BadPose{"NotANumber", pose_at(kNow, {std::nan(""), 0.0, 1.0}, 0.0)},
                      BadPose{"Infinite", pose_at(kNow, {0.0, -std::numeric_limits<double>::infinity(), 1.0}, 0.0)},
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
  EXPECT_FALSE(adapted(measure, telemetry).attitude.is_new);
  EXPECT_EQ(measure.stats().refused_attitudes, 1U);
}
INSTANTIATE_TEST_SUITE_P(
    Table, RefusedAttitude,
    ::testing::Values(BadAttitude{"NotANumber", [](protocol::Telemetry& bad) { bad.attitude[2] = std::nanf(""); }},
                      BadAttitude{"NotUnit", [](protocol::Telemetry& bad) { bad.attitude[0] = 0.9F; }}),
    [](const auto& tested) { return tested.param.name; });

TEST(SensorAdapter, NoticesAStuckSensor) {
  SensorAdapter measure;
  const protocol::Telemetry telemetry = telemetry_of({.roll_rad = 0.01}, {0.01F, 0.0F, 0.0F});
  int used = 0;
  for (int i = 0; i < 100; ++i) {
    used += adapted(measure, telemetry).attitude.is_new ? 1 : 0;
  }
  EXPECT_EQ(used, 50);
  EXPECT_EQ(measure.stats().stuck_attitudes, 50U);
}

// Motion capture that has lost the aircraft repeats the last pose with new time stamps.
TEST(SensorAdapter, TakesTheSamePoseAgainForNothingNew) {
  SensorAdapter measure;
  core::Pose<double> pose = pose_at(kNow, {1.0, 2.0, 3.0});
  EXPECT_TRUE(adapted(measure, {}, pose).pose.is_new);
  pose.set_captured_at(kNow + milliseconds(10));
  EXPECT_FALSE(adapted(measure, {}, pose, kNow + milliseconds(10)).pose.is_new);
  EXPECT_EQ(measure.stats().repeated_poses, 1U);
  pose.position_w_m.x() += 1e-9;
  EXPECT_TRUE(adapted(measure, {}, pose, kNow + milliseconds(10)).pose.is_new);
}

// In ticks of 2.5 ms. It is not known for the first attitude, after more than a second, and next to one without a time.
TEST(SensorAdapter, TheTimeSinceTheAttitudeBeforeIsByTheAutopilotsClock) {
  SensorAdapter measure;
  protocol::Telemetry telemetry = telemetry_of({}, {});
  for (const auto& [ticks, passed_us] :
       {std::pair{1000U, 0}, {1005U, 12500}, {1405U, 1000000}, {1806U, 0}, {1807U, 2500}, {0U, 0}, {1809U, 0}}) {
    telemetry.time.ticks = ticks;
    EXPECT_EQ(adapted(measure, telemetry).attitude.since_last, std::chrono::microseconds(passed_us)) << ticks;
  }
}

// Each number has a value of its own, and the force and the climb differ from what they are without telemetry.
TEST(SensorAdapter, SpecificForceComesFieldByField) {
  RecordProperty("paper", "III-A");
  SensorAdapter measure;
  protocol::Telemetry telemetry =
      telemetry_of({.roll_rad = 0.1, .pitch_rad = -0.2, .yaw_rad = 1.0}, {0.1F, 0.2F, 0.3F});
  telemetry.acceleration = {0.5F, 0.6F, -9.7F};
  telemetry.velocity_ned_m_s = {1.F, 2.F, -0.7F};
  telemetry.position.altitude_m = 99.F;
  telemetry.position.height_m = 12.5F;
  const auto measured = adapted(measure, telemetry);
  EXPECT_EQ(measured.now, kNow);
  EXPECT_EQ(measured.attitude.age, milliseconds(2));
  EXPECT_FALSE(measured.pose.is_new);
  const est::ImuSample<double> imu_sample = measure.imu_sample<double>(telemetry, measured);
  EXPECT_TRUE(imu_sample.attitude_is_new);
  EXPECT_NEAR(imu_sample.roll_rad, 0.1, 1e-6);
  EXPECT_NEAR(imu_sample.pitch_rad, -0.2, 1e-6);
  EXPECT_NEAR(imu_sample.yaw_rad, 1.0, 1e-6);
  EXPECT_NEAR(imu_sample.rate_b_rad_s.x(), 0.1, 1e-6);
  EXPECT_NEAR(imu_sample.rate_b_rad_s.y(), -0.2, 1e-6);
  EXPECT_NEAR(imu_sample.rate_b_rad_s.z(), -0.3, 1e-6);
  EXPECT_TRUE(imu_sample.force_is_new);
  EXPECT_NEAR(imu_sample.force_b.x(), 0.5, 1e-6);
  EXPECT_NEAR(imu_sample.force_b.y(), -0.6, 1e-6);
  EXPECT_NEAR(imu_sample.force_b.z(), 9.7, 1e-6);
  EXPECT_TRUE(imu_sample.climb_is_new);
  EXPECT_NEAR(imu_sample.climb_m_s, 0.7, 1e-6);
  EXPECT_TRUE(imu_sample.height_is_new);
  EXPECT_EQ(imu_sample.height_m, 12.5);
}

// The world's vertical in body axes: (-sin pitch, sin roll cos pitch, cos roll cos pitch), whatever the heading.
TEST(SensorAdapter, TheVerticalIsThatOfTheAttitude) {
  protocol::Telemetry telemetry = telemetry_of({.roll_rad = 0.1, .pitch_rad = -0.2, .yaw_rad = 1.0}, {});
  const auto up_b = SensorAdapter::vertical_b<double>(telemetry);
  ASSERT_TRUE(up_b);
  EXPECT_NEAR(up_b->x(), std::sin(0.2), 1e-6);
  EXPECT_NEAR(up_b->y(), std::sin(0.1) * std::cos(0.2), 1e-6);
  EXPECT_NEAR(up_b->z(), std::cos(0.1) * std::cos(0.2), 1e-6);
  for (const float& part : telemetry.attitude) {
    protocol::Telemetry longer = telemetry;
    longer.attitude[static_cast<std::size_t>(&part - telemetry.attitude.data())] += 2.F;
    EXPECT_FALSE(SensorAdapter::vertical_b<double>(longer)) << "each part counts in the norm";
  }
  telemetry.items = protocol::kAllTelemetryItems & ~static_cast<unsigned>(protocol::TelemetryItem::kAttitude);
  EXPECT_FALSE(SensorAdapter::vertical_b<double>(telemetry));
}

TEST(SensorAdapter, WhatTheTelemetryLacksIsNotNew) {
  const auto imu_sample_of = [](auto spoil) {
    SensorAdapter measure;
    protocol::Telemetry telemetry = telemetry_of({.roll_rad = 0.1}, {0.1F, 0.2F, 0.3F});
    telemetry.velocity_ned_m_s = {0.F, 0.F, -0.7F};
    spoil(telemetry);
    return measure.imu_sample<double>(telemetry, adapted(measure, telemetry));
  };
  const auto without = [&](protocol::TelemetryItem item) {
    return imu_sample_of([item](protocol::Telemetry& telemetry) {
      telemetry.items = static_cast<std::uint16_t>(telemetry.items & ~static_cast<unsigned>(item));
    });
  };
  EXPECT_TRUE(imu_sample_of([](protocol::Telemetry&) {}).climb_is_new);
  EXPECT_FALSE(without(protocol::TelemetryItem::kVelocity).climb_is_new);
  EXPECT_TRUE(without(protocol::TelemetryItem::kVelocity).force_is_new);
  EXPECT_FALSE(without(protocol::TelemetryItem::kAcceleration).force_is_new);
  EXPECT_TRUE(without(protocol::TelemetryItem::kAcceleration).attitude_is_new);
  for (const auto item : {protocol::TelemetryItem::kAttitude, protocol::TelemetryItem::kAngularVelocity}) {
    EXPECT_FALSE(without(item).attitude_is_new);
    EXPECT_FALSE(without(item).force_is_new) << "a force without its attitude has no direction";
  }
  EXPECT_FALSE(without(protocol::TelemetryItem::kPosition).height_is_new);
  for (const float height_m : {1e4F, -1e4F, 10001.F, -10001.F, std::nanf("")}) {
    EXPECT_EQ(imu_sample_of([=](protocol::Telemetry& bad) { bad.position.height_m = height_m; }).height_is_new,
              std::abs(height_m) <= 1e4F);
  }
  const auto climbs_at = [&](float down_m_s) {
    return imu_sample_of([=](protocol::Telemetry& telemetry) { telemetry.velocity_ned_m_s[2] = down_m_s; })
        .climb_is_new;
  };
  EXPECT_FALSE(climbs_at(0.F)) << "the autopilot has no estimate";
  EXPECT_FALSE(climbs_at(std::nanf("")));
  EXPECT_TRUE(climbs_at(0.01F));
}

/// Whether an attitude with this norm, first rate and tilt is taken.
bool is_taken(float norm, float rate_rad_s, const core::Euler<double>& flu = {}) {
  SensorAdapter measure;
  protocol::Telemetry telemetry = telemetry_of(flu, {rate_rad_s, 0.F, 0.F});
  telemetry.attitude[0] *= norm;
  return adapted(measure, telemetry).attitude.is_new;
}
bool is_taken(const core::Vector<double, 3>& position_w_m, double yaw_rad) {
  SensorAdapter measure;
  return adapted(measure, {}, pose_at(kNow, position_w_m, yaw_rad)).pose.is_new;
}

// Catches a bound that is wider or narrower than the vehicle model's, or that holds on one side or one axis only.
TEST(SensorAdapter, EachPlausibleRangeEndsWhereItIsDeclaredOnBothSides) {
  const SensorLimits limits;
  for (const float side : {1.F, -1.F}) {
    EXPECT_TRUE(is_taken(1.F + 0.95F * side * limits.norm_error, 0.F));
    EXPECT_FALSE(is_taken(1.F + 1.05F * side * limits.norm_error, 0.F));
    EXPECT_TRUE(is_taken(1.F, side * limits.rate_rad_s));
    EXPECT_FALSE(is_taken(1.F, 1.01F * side * limits.rate_rad_s));
    for (const float share : {0.99F, 1.01F}) {
      const double tilt_rad = static_cast<double>(share * side * limits.tilt_rad);
      EXPECT_EQ(is_taken(1.F, 0.F, {.roll_rad = tilt_rad}), share < 1.F);
      EXPECT_EQ(is_taken(1.F, 0.F, {.pitch_rad = tilt_rad}), share < 1.F);
      EXPECT_EQ(is_taken({0.0, 0.0, 1.0}, static_cast<double>(share * side) * 2.0 * core::kPi), share < 1.F);
      for (int axis = 0; axis < 3; ++axis) {
        core::Vector<double, 3> position_w_m(1.0, 1.0, 1.0);
        position_w_m[axis] = static_cast<double>(share * side * limits.position_m);
        EXPECT_EQ(is_taken(position_w_m, 0.0), share < 1.F) << axis;
      }
    }
  }
}

}  // namespace
}  // namespace m100::app
