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
/// Local frames of ODOMETRY whose axes are north, east, down, or forward, right, down: MAV_FRAME_LOCAL_NED, MOCAP_NED,
/// VISION_NED, ESTIM_NED, LOCAL_FRD.
constexpr std::array<std::uint8_t, 5> kNedFrames{1, 14, 16, 18, 20};
/// Positions of the variances of x, y and z in the upper triangle of a 6x6 matrix, row by row.
constexpr std::array<std::size_t, 3> kDiagonal{0, 6, 11};

using Variances = std::array<float, 3>;

Variances variances(const std::array<float, 21>& covariance) {
  return {covariance[kDiagonal[0]], covariance[kDiagonal[1]], covariance[kDiagonal[2]]};
}

/// What all three pose messages contain, in the axes of the wire.
struct Reading {
  std::uint64_t captured_us = 0;
  core::Vector<float, 3> position_ned_m;
  core::Quaternion<float> frd_in_ned;
  Variances variance_m2;  ///< of x, y, z; not above 0, or NaN: not known
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

/// The first fault found in the reading; kNone: it is valid.
PoseFault fault_of(const Reading& reading) {
  const core::Vector<float, 3>& p = reading.position_ned_m;
  const core::Quaternion<float>& q = reading.frd_in_ned;
  const auto is_number = [](float value) { return value - value == 0.F; };  // NaN and infinity fail it
  if (q.w == 0.F && q.x == 0.F && q.y == 0.F && q.z == 0.F && p.isZero(0.F)) {
    return PoseFault::kZeros;
  }
  if (!is_number(p.sum()) || !is_number(q.w + q.x + q.y + q.z)) {
    return PoseFault::kNotFinite;
  }
  if (!is_plausible(q)) {
    return PoseFault::kQuaternion;
  }
  if (!is_plausible(p)) {
    return PoseFault::kMillimetres;
  }
  return reading.captured_us > kLatestStamp_us ? PoseFault::kFastStamp : PoseFault::kNone;
}

[[gnu::noinline]] core::Expected<core::Pose<double>> pose_of(const Reading& reading, PoseAside& beside) {
  beside.fault = fault_of(reading);
  if (beside.fault != PoseFault::kNone) {
    return core::Status::kOutOfRange;
  }
  const core::Quaternion<float> attitude = core::flip_yz(reading.frd_in_ned);
  beside.flu_in_nwu = attitude;
  core::Pose<double> pose;
  pose.is_new = true;
  pose.captured = core::SenderTime(core::SenderClock::duration(static_cast<std::int64_t>(reading.captured_us)));
  pose.position_w_m = core::flip_yz(reading.position_ned_m).cast<double>();
  pose.yaw_rad = static_cast<double>(core::yaw_of(attitude));
  for (std::size_t axis = 0; axis < reading.variance_m2.size(); ++axis) {
    const float variance = reading.variance_m2[axis];
    pose.position_variance_m2[static_cast<Eigen::Index>(axis)] =
        variance > 0.F ? static_cast<double>(variance) : 0.0;  // NaN: not known
  }
  return pose;
}

core::Quaternion<float> quaternion(const std::array<float, 4>& q) { return {q[0], q[1], q[2], q[3]}; }

// Each message is decoded in its own function, which is not inlined, so that only one of them is on the stack, and none
// while the pose is computed. The result is nullopt, and `beside` has the fault, if the message has one of its own.

[[gnu::noinline]] std::optional<Reading> read_mocap(const mavlink::FrameView& frame) {
  const auto message = mavlink::decode<mavlink::AttPosMocap>(frame);
  return Reading{.captured_us = message.time_usec,
                 .position_ned_m = {message.x, message.y, message.z},
                 .frd_in_ned = quaternion(message.q),
                 .variance_m2 = variances(message.covariance)};
}

[[gnu::noinline]] std::optional<Reading> read_vision(const mavlink::FrameView& frame, PoseAside& beside) {
  const auto message = mavlink::decode<mavlink::VisionPositionEstimate>(frame);
  const core::Euler<float> euler{message.roll, message.pitch, message.yaw};
  if (!core::is_within_turn(euler.roll_rad) || !core::is_within_turn(euler.pitch_rad) ||
      !core::is_within_turn(euler.yaw_rad)) {
    const float sum = euler.roll_rad + euler.pitch_rad + euler.yaw_rad;
    beside.fault = sum - sum == 0.F ? PoseFault::kDegrees : PoseFault::kNotFinite;
    return std::nullopt;
  }
  beside.reset_counter = message.reset_counter;
  return Reading{.captured_us = message.usec,
                 .position_ned_m = {message.x, message.y, message.z},
                 .frd_in_ned = core::quaternion_of(euler),
                 .variance_m2 = variances(message.covariance)};
}

[[gnu::noinline]] std::optional<Reading> read_odometry(const mavlink::FrameView& frame, PoseAside& beside) {
  const auto message = mavlink::decode<mavlink::Odometry>(frame);
  if (std::find(kNedFrames.begin(), kNedFrames.end(), message.frame_id) == kNedFrames.end()) {
    beside.fault = PoseFault::kFrame;
    return std::nullopt;
  }
  if (message.quality < 0) {  // -1: failed; 0: unknown
    beside.fault = PoseFault::kQuality;
    return std::nullopt;
  }
  beside.reset_counter = message.reset_counter;
  return Reading{.captured_us = message.time_usec,
                 .position_ned_m = {message.x, message.y, message.z},
                 .frd_in_ned = quaternion(message.q),
                 .variance_m2 = variances(message.pose_covariance)};
}

}  // namespace

core::Expected<core::Pose<double>> decode_pose(const mavlink::FrameView& frame, PoseAside& beside) {
  std::optional<Reading> reading;
  if (mavlink::is<mavlink::AttPosMocap>(frame)) {
    reading = read_mocap(frame);
  } else if (mavlink::is<mavlink::VisionPositionEstimate>(frame)) {
    reading = read_vision(frame, beside);
  } else if (mavlink::is<mavlink::Odometry>(frame)) {
    reading = read_odometry(frame, beside);
  } else {
    return core::Status::kNotReady;
  }
  if (!reading) {
    return core::Status::kOutOfRange;
  }
  return pose_of(*reading, beside);
}

}  // namespace m100::link
