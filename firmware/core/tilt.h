// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "firmware/core/maths.h"

namespace m100::core {

/// Attitude with the heading taken out (paper, Eq. 2: "rotated into the inertial frame to get rid of the vehicle
/// heading"): where the body's z axis points, as two angles about the world's axes. With z_w that axis in the world,
///   tan(x_rad) = z_w.x / z_w.z      so that x'' = +g tan(x_rad)
///   tan(y_rad) = -z_w.y / z_w.z     so that y'' = -g tan(y_rad)
/// exactly, at any yaw, for an autopilot that keeps the vertical thrust equal to the weight. At yaw 0 they are pitch
/// and (nearly: tan(y) = tan(roll) / cos(pitch)) roll.
template <typename T>
struct Tilt {
  T x_rad{0};
  T y_rad{0};
};

namespace detail {

template <typename T>
T atan(T value) {
  return core::atan2(value, T(1));
}

}  // namespace detail

/// Body roll and pitch at a heading -> tilt. |roll|, |pitch| < pi/2.
template <typename T>
Tilt<T> tilt_of(const Euler<T>& attitude) {
  const T tan_pitch = core::tan(attitude.pitch_rad);
  const T tan_roll = core::tan(attitude.roll_rad) / core::cos(attitude.pitch_rad);
  const Vector<T, 2> w = rotate_by_yaw<T>({tan_pitch, -tan_roll}, attitude.yaw_rad);
  return {.x_rad = detail::atan(w.x()), .y_rad = detail::atan(-w.y())};
}

/// Tilt -> the roll and pitch that give it at a heading: the inverse of tilt_of.
template <typename T>
Euler<T> attitude_of(const Tilt<T>& tilt, T yaw_rad) {
  const Vector<T, 2> b = rotate_by_yaw<T>({core::tan(tilt.x_rad), -core::tan(tilt.y_rad)}, -yaw_rad);
  const T pitch_rad = detail::atan(b.x());
  return {.roll_rad = detail::atan(-b.y() * core::cos(pitch_rad)), .pitch_rad = pitch_rad, .yaw_rad = yaw_rad};
}

/// How fast the tilt changes at these body rates (FLU). Turning about the body's z axis changes nothing, exactly.
template <typename T>
Tilt<T> tilt_rate_of(const Euler<T>& attitude, const Vector<T, 3>& rate_b_rad_s) {
  const T sr = core::sin(attitude.roll_rad), cr = core::cos(attitude.roll_rad);
  const T sp = core::sin(attitude.pitch_rad), cp = core::cos(attitude.pitch_rad);
  // z axis of the body and its derivative R (w x e3), in heading axes: R = Ry(pitch) Rx(roll), w x e3 = (q, -p, 0).
  const T p = rate_b_rad_s.x(), q = rate_b_rad_s.y();
  const Vector<T, 2> zh{cr * sp, -sr};
  const T zz = cr * cp;
  const Vector<T, 2> zh_dot{cp * q - sp * sr * p, -cr * p};
  const T zz_dot = -sp * q - cp * sr * p;
  const Vector<T, 2> slope = rotate_by_yaw<T>(zh / zz, attitude.yaw_rad);
  const Vector<T, 2> slope_dot = rotate_by_yaw<T>((zh_dot - zh * (zz_dot / zz)) / zz, attitude.yaw_rad);
  return {.x_rad = slope_dot.x() / (T(1) + slope.x() * slope.x()),
          .y_rad = -slope_dot.y() / (T(1) + slope.y() * slope.y())};
}

/// Yaw rate of the z-y-x angles at these body rates: psi' = (q sin(roll) + r cos(roll)) / cos(pitch).
template <typename T>
T yaw_rate_of(const Euler<T>& attitude, const Vector<T, 3>& rate_b_rad_s) {
  return (rate_b_rad_s.y() * core::sin(attitude.roll_rad) + rate_b_rad_s.z() * core::cos(attitude.roll_rad)) /
         core::cos(attitude.pitch_rad);
}

}  // namespace m100::core
