// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"

namespace m100::est {

/// What the autopilot tells of its motion in one tick; a part that is not new is no evidence.
template <typename T>
struct Felt {
  bool attitude_is_new = false;
  bool force_is_new = false;
  bool climb_is_new = false;
  T roll_rad{0};
  T pitch_rad{0};
  T yaw_rad{0};
  core::Vector<T, 3> rate_b_rad_s = core::Vector<T, 3>::Zero();  ///< FLU
  core::Vector<T, 3> force_b = core::Vector<T, 3>::Zero();       ///< specific force, FLU, in m/s^2 or in g
  T climb_m_s{0};
};

/// The force is averaged over this, or the rotors would count as motion.
inline constexpr double kFeltMean_s = 0.1;

}  // namespace m100::est
