// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "firmware/companion/files/pose_options.h"
#include "firmware/companion/preflight/check_result.h"
#include "protocol/mavlink/pose_wire.h"

namespace m100::companion::preflight {

/// Where poses will come from, as the operator gives it.
struct PosePlan {
  PoseOptions source;  ///< no port: none is checked
  std::string autopilot_port;
  std::string message{mavlink::kPoseWires.front().name};
  double rate_hz = 100.0;
};

/// The names that PosePlan::message may have.
std::vector<std::string> pose_messages();

/// Whether the planned rate of poses, with signatures, fits into the serial line. Not for a network.
CheckResult check_pose_line(const PosePlan& line);

/// Checks the port, its key, and the poses that arrive within two seconds. No results if no port is named.
std::vector<CheckResult> check_pose_port(const PosePlan& line);

}  // namespace m100::companion::preflight
