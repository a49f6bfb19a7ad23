// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/companion/files/pose_options.h"
#include "firmware/companion/preflight/check_result.h"
#include "protocol/mavlink/pose_wire.h"

namespace m100::companion::preflight {

/// Where poses will come from, as the operator gives it.
struct PosePlan {
  PoseOptions source;  ///< no port: none is checked
  std::string message{mavlink::kPoseWires.front().name};
  double rate_hz = 100.0;
};

/// The names that PosePlan::message may have.
std::vector<std::string> pose_messages();

/// Whether the planned rate of poses, with signatures, fits into the serial line. Not for a network.
CheckResult check_pose_line(const PosePlan& line);

/// Checks the port, its key, and the poses that arrive within two seconds. No results if no port is named.
/// @param autopilot name of its port; may be empty.
std::vector<CheckResult> check_pose_port(const PosePlan& line, const std::string& autopilot);

/// Listens to both ports while the operator moves the aircraft by hand; sends nothing to the autopilot, and judges with
/// AxisAlignment. Errors: UsageError.
std::vector<CheckResult> check_frames(const std::string& autopilot, std::uint32_t baud, const PoseOptions& pose,
                                      double hold_s);

}  // namespace m100::companion::preflight
