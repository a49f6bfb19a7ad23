// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::lab::bridge {

/// A pose as rooms send it by plain UDP: eight numbers, `t x y z qw qx qy qz`. t in seconds from wherever the sender
/// likes, metres, body to world.
struct PlainPose {
  double t_s = 0.0;
  core::Vector<double, 3> position_m = core::Vector<double, 3>::Zero();
  core::Quaternion<double> body_to_world{};
};

/// Axes of the room, and with them those of the body.
enum class Axes {
  kNwu,  ///< x forward, y left, z up; body likewise
  kNed,  ///< x north, y east, z down; body forward, right, down: MAVLink's own
  kEnu,  ///< x east, y north, z up; body forward, left, up (ROS)
};
std::optional<Axes> axes_of(std::string_view word);

/// All numbers finite, at most 1 km away, a quaternion whose length is one to 1 %, a time between 0 and 285 years.
bool is_believable(const PlainPose& pose);

/// Reads a packet: eight numbers as text with spaces or commas between them, or as 64 bytes of doubles, little endian.
/// @returns nothing: fewer or more numbers, or none that is_believable().
std::optional<PlainPose> parse_packet(std::span<const std::byte> packet);

/// The same for MAVLink: NED and FRD, no covariance. @param time_usec of the capture, as it shall be sent.
mavlink::AttPosMocap message_of(const PlainPose& pose, Axes axes, std::uint64_t time_usec);

}  // namespace m100::lab::bridge
