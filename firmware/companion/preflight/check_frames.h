// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/companion/fly/pose_port.h"
#include "firmware/companion/preflight/check_result.h"

namespace m100::companion::preflight {

/// The options of `m100 doctor --frames`.
struct CheckFramesOptions {
  std::string port;  ///< of the autopilot
  std::uint32_t baud = 230400;
  PoseOptions pose;
  double hold_s = 30.0;
};

/// Listens to both ports while the operator moves the aircraft by hand; sends nothing to the autopilot, and judges with
/// AxisAlignment. Errors: UsageError.
std::vector<CheckResult> check_frames(const CheckFramesOptions& options);

}  // namespace m100::companion::preflight
