// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/link/pose/pose_decoder.h"

#include <algorithm>
#include <array>

#include "firmware/core/frames.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::link {
namespace {

constexpr float kFarthest_m = 1000.F;
constexpr std::uint64_t kLatestStamp_us = std::uint64_t{1} << 53U;  // 285 years
constexpr float kLengthError = 0.02F;                               // of the squared length: twice that of the length
constexpr float kLargestVariance_m2 = 100.F;
/// Local frames of ODOMETRY whose axes are north, east, down, or forward, right, down: MAV_FRAME_LOCAL_NED, MOCAP_NED,
/// VISION_NED, ESTIM_NED, LOCAL_FRD.
constexpr std::array<std::uint8_t, 5> kNedFrames{1, 14, 16, 18, 20};
/// Positions of the variances of x, y and z in the upper right of a 6x6 matrix, row by row.
constexpr std::array<std::size_t, 3> kDiagonal{0, 6, 11};

using Variances = std::array<float, 3>;

Variances variances(const std::array<float, 21>& covariance) {
  return {covariance[kDiagonal[0]], covariance[kDiagonal[1]], covariance[kDiagonal[2]]};
}

/// The common content of all three messages, in the types of the wire.
struct Reading {
  std::uint64_t captured_us = 0;
  core::Vector<float, 3> position_ned_m;
  core::Quaternion<float> frd_in_ned;
  Variances variance_m2;  ///< of x, y, z; 0 or no number: not known
};

// A comparison with NaN is false, so each test states the valid range.
bool is_plausible(const core::Vector<float, 3>& p) {
  const auto near = [](float value) { return value >= -kFarthest_m && value <= kFarthest_m; };
  return near(p.x()) && near(p.y()) && near(p.z());
}

bool is_plausible(const core::Quaternion<float>& q) {
  const float squared = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return squared >= 1.F - kLengthError && squared <= 1.F + kLengthError;
}

core::Expected<core::Pose<double>> pose_of(const Reading& reading) {
  if (reading.captured_us > kLatestStamp_us || !is_plausible(reading.position_ned_m) ||
      !is_plausible(reading.frd_in_ned)) {
    return core::Status::kOutOfRange;
  }
  core::Pose<double> pose;
  pose.is_new = true;
  pose.captured = core::SenderTime(core::SenderClock::duration(static_cast<std::int64_t>(reading.captured_us)));
  pose.position_w_m = core::flip_yz(reading.position_ned_m).cast<double>();
  pose.yaw_rad = static_cast<double>(core::yaw_of(core::flip_yz(reading.frd_in_ned)));
  for (std::size_t axis = 0; axis < reading.variance_m2.size(); ++axis) {
    const float variance = reading.variance_m2[axis];
    if (variance > kLargestVariance_m2) {
      return core::Status::kOutOfRange;
    }
    pose.position_variance_m2[static_cast<Eigen::Index>(axis)] =
        variance > 0.F ? static_cast<double>(variance) : 0.0;  // NaN: not known
  }
  return pose;
}

core::Quaternion<float> quaternion(const std::array<float, 4>& q) { return {q[0], q[1], q[2], q[3]}; }

// Each message is decoded in its own function, which is not inlined, so that only one of them is on the stack.

[[gnu::noinline]] core::Expected<core::Pose<double>> read_mocap(const mavlink::FrameView& frame) {
  const auto message = mavlink::decode<mavlink::AttPosMocap>(frame);
  return pose_of({.captured_us = message.time_usec,
                  .position_ned_m = {message.x, message.y, message.z},
                  .frd_in_ned = quaternion(message.q),
                  .variance_m2 = variances(message.covariance)});
}

[[gnu::noinline]] core::Expected<core::Pose<double>> read_vision(const mavlink::FrameView& frame) {
  const auto message = mavlink::decode<mavlink::VisionPositionEstimate>(frame);
  constexpr float kTurns = 100.F;  // a larger number is not an angle, and costs accuracy
  const core::Euler<float> euler{message.roll, message.pitch, message.yaw};
  const auto good = [](float angle) { return angle >= -kTurns && angle <= kTurns; };
  if (!good(euler.roll_rad) || !good(euler.pitch_rad) || !good(euler.yaw_rad)) {
    return core::Status::kOutOfRange;
  }
  return pose_of({.captured_us = message.usec,
                  .position_ned_m = {message.x, message.y, message.z},
                  .frd_in_ned = core::quaternion_of(euler),
                  .variance_m2 = variances(message.covariance)});
}

[[gnu::noinline]] core::Expected<core::Pose<double>> read_odometry(const mavlink::FrameView& frame) {
  const auto message = mavlink::decode<mavlink::Odometry>(frame);
  if (std::find(kNedFrames.begin(), kNedFrames.end(), message.frame_id) == kNedFrames.end()) {
    return core::Status::kOutOfRange;
  }
  return pose_of({.captured_us = message.time_usec,
                  .position_ned_m = {message.x, message.y, message.z},
                  .frd_in_ned = quaternion(message.q),
                  .variance_m2 = variances(message.pose_covariance)});
}

}  // namespace

core::Expected<core::Pose<double>> decode_pose(const mavlink::FrameView& frame) {
  if (mavlink::is<mavlink::AttPosMocap>(frame)) {
    return read_mocap(frame);
  }
  if (mavlink::is<mavlink::VisionPositionEstimate>(frame)) {
    return read_vision(frame);
  }
  if (mavlink::is<mavlink::Odometry>(frame)) {
    return read_odometry(frame);
  }
  return core::Status::kNotReady;
}

}  // namespace m100::link
