// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "firmware/core/pose.h"
#include "firmware/core/standing_turn.h"
#include "firmware/core/time.h"

namespace m100::est {

/// What the specific force shows beside that which the tilt accelerates with: wind and drag (world, horizontal, m/s^2),
/// without the force's own offset.
template <typename T>
struct Push {
  bool is_known = false;                                        ///< the force comes, and is one
  core::Vector<T, 2> now_w_m_s2 = core::Vector<T, 2>::Zero();   ///< of the newest message, with the rotors' shaking
  core::Vector<T, 2> mean_w_m_s2 = core::Vector<T, 2>::Zero();  ///< over a tenth of a second
};

/// What the sensors say in one tick, already in our frames (world NWU, body FLU), SI. Each part says whether it is new.
/// T is float or double.
template <typename T>
struct Measurement {
  /// From the autopilot's telemetry.
  struct Attitude {
    bool is_new = false;
    core::Duration age{0};
    T roll_rad{0};
    T pitch_rad{0};
    T yaw_rad{0};
    core::Vector<T, 3> rate_b_rad_s = core::Vector<T, 3>::Zero();
    mutable core::TiltTurns<T> turns{};

    /// Sine and cosine, taken once for all who ask.
    const core::Turn<T>& roll() const { return turns.roll.of(roll_rad); }
    const core::Turn<T>& pitch() const { return turns.pitch.of(pitch_rad); }
  };
  core::TimePoint now{};  ///< of this tick: what ages count to
  core::Pose<T> pose;     ///< from motion capture or another source of pose
  Attitude attitude;
  Push<T> push;  ///< by CrossCheck, of the tick before
};

}  // namespace m100::est
