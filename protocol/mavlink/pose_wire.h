// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "protocol/mavlink/frame.h"
#include "protocol/mavlink/pose_messages.h"

namespace m100::mavlink {

/// The bytes of an unsigned pose message on a serial line.
struct PoseWire {
  std::string_view name;
  std::size_t bytes;
};

/// The longest form of each message, in the first two rows without its extension fields.
inline constexpr std::array kPoseWires{
    PoseWire{"ATT_POS_MOCAP", AttPosMocap::kInfo.min_bytes + kHeader2Bytes + kCrcBytes},
    PoseWire{"VISION_POSITION_ESTIMATE", VisionPositionEstimate::kInfo.min_bytes + kHeader2Bytes + kCrcBytes},
    PoseWire{"ATT_POS_MOCAP+covariance", AttPosMocap::kInfo.full_bytes + kHeader2Bytes + kCrcBytes},
    PoseWire{"VISION_POSITION_ESTIMATE+covariance",
             VisionPositionEstimate::kInfo.full_bytes + kHeader2Bytes + kCrcBytes},
    PoseWire{"ODOMETRY", Odometry::kInfo.full_bytes + kHeader2Bytes + kCrcBytes},
};
static_assert(kPoseWires[0].bytes <= 80 && kPoseWires[1].bytes <= 80);

/// Above this share of a line, poses leave no room for TIMESYNC and for bursts.
inline constexpr double kMaxPoseShare = 0.8;

/// Share of a line of 8N1 that poses take.
constexpr double line_share(const PoseWire& wire, double rate_hz, double baud) {
  constexpr double kBitsPerByte = 10.0;
  return static_cast<double>(wire.bytes) * kBitsPerByte * rate_hz / baud;
}

}  // namespace m100::mavlink
