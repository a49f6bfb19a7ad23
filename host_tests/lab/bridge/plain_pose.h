// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "firmware/link/pose/pose_fault.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::lab::bridge {

/// A pose as motion-capture systems send it by plain UDP: eight numbers, `t x y z qw qx qy qz`. t [s] on any clock of
/// the sender, position [m], quaternion from body to world.
struct PlainPose {
  double t_s = 0.0;
  core::Vector<double, 3> position_m = core::Vector<double, 3>::Zero();
  core::Quaternion<double> body_to_world{};
};

/// Axes of the room and of the body.
enum class Axes {
  kNwu,  ///< x forward, y left, z up; body likewise
  kNed,  ///< x north, y east, z down; body forward, right, down: MAVLink's own
  kEnu,  ///< x east, y north, z up; body forward, left, up (ROS)
};
std::optional<Axes> axes_of(std::string_view word);

/// kNone: all numbers are finite, each coordinate is within 1 km, the quaternion's length is 1 within 1 %, and the time
/// is between 0 and 285 years.
link::PoseFault fault_of(const PlainPose& pose);

/// Reads a packet: eight numbers as text separated by spaces or commas, or as 64 bytes of doubles, little endian.
/// @returns nothing if there are fewer or more numbers, or if the pose has a fault.
/// @param fault receives, if not null, the pose's fault; unchanged if the packet is not eight numbers.
std::optional<PlainPose> parse_packet(std::span<const std::byte> packet, link::PoseFault* fault = nullptr);

/// The pose as MAVLink message: NED and FRD, no covariance. @param time_usec time of capture to send [us].
mavlink::AttPosMocap message_of(const PlainPose& pose, Axes axes, std::uint64_t time_usec);

}  // namespace m100::lab::bridge
