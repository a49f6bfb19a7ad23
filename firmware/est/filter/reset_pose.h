// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/core/time.h"

// Shared by disturbance_ekf.cpp (the tick), command_history.cpp, fuse_pose.cpp and reset_pose.cpp (start and restart).
namespace m100::est {

inline constexpr double kLargestAttitude_rad = 1.2;  ///< of attitudes and commands
inline constexpr core::Duration kDropout = std::chrono::milliseconds(500);
inline constexpr core::Duration kPoseLost = std::chrono::milliseconds(1000);  ///< then the prediction is abandoned
inline constexpr core::Duration kResetSpacing = std::chrono::milliseconds(2000);

template <typename Real>
bool finite(Real value) {
  return value - value == Real(0);
}

template <typename Pose>
auto wrapped_yaw(const Pose& pose) {
  using Real = decltype(pose.yaw_rad);
  return core::wrap_pi(core::clamp<Real>(pose.yaw_rad, Real(-100), Real(100)));
}

}  // namespace m100::est
