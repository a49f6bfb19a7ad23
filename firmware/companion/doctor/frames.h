// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware/companion/doctor/check.h"
#include "firmware/companion/fly/pose_port.h"

namespace m100::companion::doctor {

/// The options of `m100 doctor --frames`.
struct FramesOptions {
  std::string port;  ///< of the autopilot
  std::uint32_t baud = 230400;
  PoseOptions pose;
  double hold_s = 30.0;
};

/// Listens to both ports while the operator moves the aircraft by hand, and sends nothing to the autopilot.
/// Errors: UsageError.
std::vector<Check> check_frames(const FramesOptions& options);

}  // namespace m100::companion::doctor
