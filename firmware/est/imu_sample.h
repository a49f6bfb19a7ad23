// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/cached_sin_cos.h"
#include "firmware/core/eigen.h"

namespace m100::est {

/// The autopilot's measurements of its own motion in one tick, FLU in NWU. A flag is true if its part is new in this
/// tick.
template <typename T>
struct ImuSample {
  bool attitude_is_new = false;
  bool force_is_new = false;
  bool climb_is_new = false;
  bool height_is_new = false;
  T since_last_s{0};  ///< since the attitude before, by the autopilot's clock; 0: not known
  T roll_rad{0};
  T pitch_rad{0};
  T yaw_rad{0};
  core::Vector<T, 3> rate_b_rad_s = core::Vector<T, 3>::Zero();  ///< FLU
  core::Vector<T, 3> force_b = core::Vector<T, 3>::Zero();       ///< specific force, FLU, in m/s^2 or in g
  T climb_m_s{0};
  T height_m{0};  ///< above the autopilot's home point
  mutable core::RollPitchSinCos<T> sin_cos{};

  /// Sine and cosine, computed once for all callers.
  const core::SinCos<T>& roll() const { return sin_cos.roll.of(roll_rad); }
  const core::SinCos<T>& pitch() const { return sin_cos.pitch.of(pitch_rad); }
};

/// Averaging time of the specific force. It removes the rotors' vibration.
inline constexpr double kForceMean_s = 0.1;

}  // namespace m100::est
