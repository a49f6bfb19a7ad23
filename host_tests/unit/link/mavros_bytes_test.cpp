// SPDX-License-Identifier: BSD-3-Clause
// The frames that MAVROS 1.x sends, in bytes. They were packed by a program of a few lines from MAVLink's message
// definitions and from what the plugins of MAVROS fill in (system 1, component 240, MAVLink 2, unsigned), not by our
// encoder: a pose of 2 m north, 1 m east, 3 m up; set points of setpoint_position, setpoint_raw and setpoint_velocity.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/core/frames.h"
#include "firmware/link/pose/pose_decoder.h"
#include "protocol/mavlink/messages.h"
#include "protocol/mavlink/parser.h"

namespace m100::link {
namespace {

constexpr std::string_view kHeartbeat = "fd0900000001f0000000000000001208c00403fc21";
constexpr std::string_view kTimesync = "fd1000000101f06f0000000000000000000000ca853dfe9c9717bd4f";
constexpr std::string_view kTimesyncAnswer = "fd0c00000201f06f000000ca853dfe9c971700f902959c23";
constexpr std::string_view kVisionPose =
    "fd2000000301f066000040222018240a0600000000400000803f000040c0cdcccc3dcdcc4cbe9a99993e75c3";
constexpr std::string_view kVisionPoseWithCovariance =
    "fd7400000301f066000040222018240a0600000000400000803f000040c0cdcccc3dcdcc4cbe9a99993e17b7d13800000000"
    "0000000000000000000000000000000017b7d13900000000000000000000000000000000faed6b3a00000000000000000000"
    "00000ad7233c00000000000000000ad7233c000000000ad7233cca76";
constexpr std::string_view kOdometry =
    "fde600000401f04b010040222018240a0600000000400000803f000040c00000003f0000003f0000003f0000003fcdcccc3d"
    "cdcc4c3e9a99993ecdcccc3e0000003f9a99193f17b7d138000000000000000000000000000000000000000017b7d1390000"
    "0000000000000000000000000000faed6b3a0000000000000000000000000ad7233c00000000000000000ad7233c00000000"
    "0ad7233c17b7d138000000000000000000000000000000000000000017b7d13900000000000000000000000000000000faed"
    "6b3a0000000000000000000000000ad7233c00000000000000000ad7233c000000000ad7233c140c719b";
constexpr std::string_view kSetpointPosition =
    "fd3500000501f05400007b68e5cf000000400000803f000040c0000000000000000000000000000000000000000000000000"
    "0000003f00000000f8090101011637";
constexpr std::string_view kSetpointRaw =
    "fd3500000601f05400007b68e5cf000000400000803f000040c00000003f000080be0000003e0000803f00000040000000bf"
    "0000003f0000803e000001010158ae";
constexpr std::string_view kSetpointVelocity =
    "fd3500000701f05400007b68e5cf0000000000000000000000000000003f000080be0000003e000000000000000000000000"
    "000000000000803ec70501010137ad";

constexpr mavlink::Address kMavros{.system = 1, .component = 240};
constexpr std::int64_t kStamp_us = 1700000000123456;

std::vector<std::byte> bytes_of(std::string_view hex) {
  std::vector<std::byte> bytes;
  for (std::size_t at = 0; at < hex.size(); at += 2) {
    bytes.push_back(static_cast<std::byte>(std::strtol(std::string(hex.substr(at, 2)).c_str(), nullptr, 16)));
  }
  return bytes;
}

/// Hands the one frame of the bytes to a function.
template <typename Use>
void read(std::string_view hex, const Use& use) {
  mavlink::Parser parser;
  int frames = 0;
  parser.consume(bytes_of(hex), [&](const mavlink::FrameView& frame) {
    ++frames;
    EXPECT_TRUE(frame.from == kMavros);
    use(frame);
  });
  EXPECT_EQ(frames, 1) << hex;
}

core::Pose<double> pose_of(std::string_view hex) {
  core::Pose<double> read_pose;
  read(hex, [&](const mavlink::FrameView& frame) {
    PoseAside beside;
    const core::Expected<core::Pose<double>> pose = decode_pose(frame, beside);
    ASSERT_TRUE(pose) << static_cast<int>(beside.fault);
    read_pose = *pose;
  });
  return read_pose;
}

TEST(MavrosBytes, PosesHaveOurAxesTheirStampAndTheirVariance) {
  for (const std::string_view hex : {kVisionPose, kVisionPoseWithCovariance, kOdometry}) {
    const core::Pose<double> pose = pose_of(hex);
    EXPECT_EQ(pose.captured.time_since_epoch().count(), kStamp_us);
    EXPECT_LT((pose.position_w_m - core::Vector<double, 3>(2.0, -1.0, 3.0)).norm(), 1e-6) << hex;
  }
  EXPECT_NEAR(pose_of(kVisionPose).yaw_rad, -0.3, 1e-6) << "clockwise from above is ours with a minus";
  // q = (0.5, 0.5, 0.5, 0.5) in FRD and NED turns x to y: the nose points east.
  EXPECT_NEAR(std::abs(pose_of(kOdometry).yaw_rad), core::kPi / 2.0, 1e-6);
  EXPECT_EQ(pose_of(kVisionPose).position_variance_m2.x(), 0.0) << "zeros in a covariance: not known";
  for (const std::string_view hex : {kVisionPoseWithCovariance, kOdometry}) {
    EXPECT_NEAR(pose_of(hex).position_variance_m2.y(), 4e-4, 1e-9);
    EXPECT_NEAR(pose_of(hex).position_variance_m2.z(), 9e-4, 1e-9);
  }
}

TEST(MavrosBytes, SetPointsHaveTheirMasksAndNumbers) {
  using Target = mavlink::SetPositionTargetLocalNed;
  const auto check = [](std::string_view hex, std::uint16_t mask, const auto& more) {
    read(hex, [&](const mavlink::FrameView& frame) {
      ASSERT_TRUE(mavlink::is<Target>(frame));
      const auto target = mavlink::decode<Target>(frame);
      EXPECT_EQ(target.type_mask, mask);
      EXPECT_EQ(target.coordinate_frame, 1);
      EXPECT_EQ(target.target_system, 1);
      EXPECT_EQ(target.time_boot_ms, static_cast<std::uint32_t>(kStamp_us / 1000));
      more(target);
    });
  };
  check(kSetpointPosition, 2552, [](const Target& target) {
    EXPECT_EQ(target.x, 2.F);
    EXPECT_EQ(target.z, -3.F);
    EXPECT_EQ(target.yaw, 0.5F);
  });
  check(kSetpointRaw, 0, [](const Target& target) {
    EXPECT_EQ(target.vy, -0.25F);
    EXPECT_EQ(target.afz, -0.5F);
    EXPECT_EQ(target.yaw_rate, 0.25F);
  });
  check(kSetpointVelocity, 1479, [](const Target& target) { EXPECT_EQ(target.vx, 0.5F); });
}

TEST(MavrosBytes, HeartbeatAndTimeAreReadAndAreNoPose) {
  for (const std::string_view hex : {kHeartbeat, kTimesync, kTimesyncAnswer, kSetpointRaw}) {
    read(hex, [](const mavlink::FrameView& frame) {
      PoseAside beside;
      EXPECT_EQ(decode_pose(frame, beside).status(), core::Status::kNotReady);
    });
  }
  read(kTimesync, [](const mavlink::FrameView& frame) {
    EXPECT_EQ(mavlink::decode<mavlink::Timesync>(frame).tc1, 0);
    EXPECT_EQ(mavlink::decode<mavlink::Timesync>(frame).ts1, kStamp_us * 1000);
  });
  read(kTimesyncAnswer, [](const mavlink::FrameView& frame) {
    EXPECT_EQ(mavlink::decode<mavlink::Timesync>(frame).tc1, kStamp_us * 1000);
    EXPECT_EQ(mavlink::decode<mavlink::Timesync>(frame).ts1, 2'500'000'000);
  });
}

}  // namespace
}  // namespace m100::link
