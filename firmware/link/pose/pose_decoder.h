// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/core/expected.h"
#include "firmware/core/frames.h"
#include "firmware/core/pose.h"
#include "firmware/link/pose/pose_fault.h"
#include "protocol/mavlink/frame.h"

namespace m100::link {

/// What decode_pose() returns besides the pose.
struct PoseAside {
  PoseFault fault = PoseFault::kNone;         ///< why the pose is refused
  std::optional<std::uint8_t> reset_counter;  ///< of the message, if its kind has one
  core::Quaternion<float> flu_in_nwu{};       ///< the pose's own attitude
};

/// The pose in a frame of ATT_POS_MOCAP, VISION_POSITION_ESTIMATE or ODOMETRY, in our frames: NED and FRD of the wire
/// become world NWU and body FLU. `captured` is the sender's time stamp, zero without a stamp; a variance that the
/// sender does not know, or reports as zero or negative, is zero.
/// @returns kNotReady: another message. kOutOfRange: an impossible pose: all zeros, a number that is not finite, a
///   position beyond 1 km, a quaternion whose length is not one to 1 %, angles beyond 2 pi, a stamp beyond 285 years,
///   ODOMETRY in a frame that is not NED or FRD, or of a negative quality.
core::Expected<core::Pose<double>> decode_pose(const mavlink::FrameView& frame, PoseAside& beside);

}  // namespace m100::link
