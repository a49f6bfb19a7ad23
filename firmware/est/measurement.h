// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/cached_sin_cos.h"
#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "firmware/core/pose.h"
#include "firmware/core/time.h"

namespace m100::est {

/// The part of the specific force that the tilt does not explain: acceleration by wind and drag (world, horizontal,
/// m/s^2), without the offset of the force.
template <typename T>
struct DisturbanceAcceleration {
  bool is_known = false;                                        ///< a force arrives, and its sensor's error is known
  core::Vector<T, 2> now_w_m_s2 = core::Vector<T, 2>::Zero();   ///< of the newest message, with the rotors' vibration
  core::Vector<T, 2> mean_w_m_s2 = core::Vector<T, 2>::Zero();  ///< mean over a tenth of a second
};

/// The measurements of one tick, converted to our frames (world NWU, body FLU), SI units. Pose and attitude carry a
/// flag that is true if they are new. T is float or double.
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
  core::TimePoint now{};  ///< time of this tick; ages count up to it
  core::Pose<T> pose;     ///< from motion capture or another source of pose
  Attitude attitude;
  DisturbanceAcceleration<T> disturbance_acceleration;  ///< from VelocityConsistency, of the tick before
};

}  // namespace m100::est
