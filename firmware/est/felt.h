// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/standing_turn.h"

namespace m100::est {

/// The autopilot's measurements of its own motion in one tick; a part that is not new is not used as evidence.
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
  mutable core::TiltTurns<T> turns{};

  /// Sine and cosine, computed once for all callers.
  const core::Turn<T>& roll() const { return turns.roll.of(roll_rad); }
  const core::Turn<T>& pitch() const { return turns.pitch.of(pitch_rad); }
};

/// Averaging time of the force; without it the rotors' vibration would count as motion.
inline constexpr double kFeltMean_s = 0.1;

}  // namespace m100::est
