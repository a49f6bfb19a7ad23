// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/cached_sin_cos.h"
#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "firmware/core/pose.h"
#include "firmware/core/time.h"

namespace m100::est {

/// Acceleration by wind and drag: the part of the specific force that the tilt does not explain. World frame,
/// horizontal, m/s^2. The offset of the force sensor has been removed.
template <typename T>
struct DisturbanceAcceleration {
  bool is_known = false;                                        ///< a force arrives, and its sensor's error is known
  core::Vector<T, 2> now_w_m_s2 = core::Vector<T, 2>::Zero();   ///< of the newest message, with the rotors' vibration
  core::Vector<T, 2> mean_w_m_s2 = core::Vector<T, 2>::Zero();  ///< mean over a tenth of a second
};

/// The measurements of one tick, in our frames (world NWU, body FLU) and SI units. T is float or double.
template <typename T>
struct Measurement {
  /// From the autopilot's telemetry.
  struct Attitude {
    bool is_new = false;
    core::Duration age{0};
    core::Duration since_last{0};  ///< since the attitude before, by the autopilot's clock; 0: not known
    T roll_rad{0};
    T pitch_rad{0};
    T yaw_rad{0};
    core::Vector<T, 3> rate_b_rad_s = core::Vector<T, 3>::Zero();
    mutable core::RollPitchSinCos<T> sin_cos{};

    /// Sine and cosine, computed once for all callers.
    const core::SinCos<T>& roll() const { return sin_cos.roll.of(roll_rad); }
    const core::SinCos<T>& pitch() const { return sin_cos.pitch.of(pitch_rad); }
  };
  core::TimePoint now{};  ///< time of this tick
  core::Pose<T> pose;     ///< from motion capture or another source of pose
  Attitude attitude;
  DisturbanceAcceleration<T> disturbance_acceleration;  ///< from VelocityConsistency, of the tick before
};

}  // namespace m100::est
