// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"
#include "firmware/core/maths.h"

namespace m100::core {

/// Attitude without the heading (paper, Eq. 2: "rotated into the inertial frame to get rid of the vehicle heading"):
/// the direction of the body's z axis as two angles about the world's axes. With z_w that axis in the world,
///   tan(x_rad) = z_w.x / z_w.z      so that x'' = +g tan(x_rad)
///   tan(y_rad) = -z_w.y / z_w.z     so that y'' = -g tan(y_rad)
/// exactly, at any yaw, for an autopilot that keeps the vertical thrust equal to the weight. At yaw 0 they are pitch
/// and (nearly: tan(y) = tan(roll) / cos(pitch)) roll.
template <typename T>
struct Tilt {
  T x_rad{0};
  T y_rad{0};
};

/// A tilt as slopes: the tangents of its two angles.
template <typename T>
struct Slope {
  T x{0};
  T y{0};
};

/// Sines and cosines of an attitude, computed once for all later uses.
template <typename T>
struct AttitudeSinCos {
  SinCos<T> roll;
  SinCos<T> pitch;
  SinCos<T> yaw;
};

template <typename T>
AttitudeSinCos<T> attitude_sin_cos(const Euler<T>& attitude) {
  return {.roll = sin_cos_of(attitude.roll_rad),
          .pitch = sin_cos_of(attitude.pitch_rad),
          .yaw = sin_cos_of(attitude.yaw_rad)};
}

/// Slope of the body's z axis forward and left, in heading axes.
template <typename T>
Vector<T, 2> heading_slope_of(const SinCos<T>& roll, const SinCos<T>& pitch) {
  return {pitch.sine / pitch.cosine, -(roll.sine / (roll.cosine * pitch.cosine))};
}

/// Roll and pitch at a heading -> slopes of the thrust in the world. |roll|, |pitch| < pi/2.
template <typename T>
Slope<T> slope_of(const AttitudeSinCos<T>& a) {
  const Vector<T, 2> w = rotate<T>(heading_slope_of(a.roll, a.pitch), a.yaw);
  return {.x = w.x(), .y = -w.y()};
}

/// Caches the heading slope of a roll and pitch that stay constant for several ticks while the heading turns: the same
/// numbers as slope_of, at a lower cost.
template <typename T>
class CachedTilt {
 public:
  Slope<T> at(T roll_rad, T pitch_rad, const SinCos<T>& yaw) {
    if (!(roll_rad == roll_rad_ && pitch_rad == pitch_rad_)) {
      roll_rad_ = roll_rad;
      pitch_rad_ = pitch_rad;
      slope_ = heading_slope_of(sin_cos_of(roll_rad), sin_cos_of(pitch_rad));
    }
    const Vector<T, 2> w = rotate<T>(slope_, yaw);
    return {.x = w.x(), .y = -w.y()};
  }

 private:
  T roll_rad_{0};
  T pitch_rad_{0};
  Vector<T, 2> slope_{T(0), T(0)};
};

template <typename T>
Tilt<T> tilt_of(const Slope<T>& slope) {
  return {.x_rad = core::atan2(slope.x, T(1)), .y_rad = core::atan2(slope.y, T(1))};
}

template <typename T>
Tilt<T> tilt_of(const Euler<T>& attitude) {
  return tilt_of(slope_of(attitude_sin_cos(attitude)));
}

/// Slopes -> the roll and pitch that give them at a heading: the inverse of slope_of.
template <typename T>
Euler<T> attitude_of(const Slope<T>& slope, T yaw_rad, const SinCos<T>& yaw) {
  const Vector<T, 2> b = rotate<T>({slope.x, -slope.y}, {.sine = -yaw.sine, .cosine = yaw.cosine});
  const T cos_pitch = T(1) / core::sqrt(T(1) + b.x() * b.x());
  return {.roll_rad = core::atan2(-b.y() * cos_pitch, T(1)), .pitch_rad = core::atan2(b.x(), T(1)), .yaw_rad = yaw_rad};
}

template <typename T>
Euler<T> attitude_of(const Tilt<T>& tilt, T yaw_rad) {
  return attitude_of(Slope<T>{.x = core::tan(tilt.x_rad), .y = core::tan(tilt.y_rad)}, yaw_rad, sin_cos_of(yaw_rad));
}

/// Rate of change of the tilt at these body rates (FLU). A turn about the body's z axis changes nothing, exactly.
template <typename T>
Tilt<T> tilt_rate_of(const AttitudeSinCos<T>& a, const Vector<T, 3>& rate_b_rad_s) {
  const T sr = a.roll.sine, cr = a.roll.cosine;
  const T sp = a.pitch.sine, cp = a.pitch.cosine;
  // z axis of the body and its derivative R (w x e3), in heading axes: R = Ry(pitch) Rx(roll), w x e3 = (q, -p, 0).
  const T p = rate_b_rad_s.x(), q = rate_b_rad_s.y();
  const Vector<T, 2> zh{cr * sp, -sr};
  const T zz = cr * cp;
  const Vector<T, 2> zh_dot{cp * q - sp * sr * p, -cr * p};
  const T zz_dot = -sp * q - cp * sr * p;
  const Vector<T, 2> slope = rotate<T>(zh / zz, a.yaw);
  const Vector<T, 2> slope_dot = rotate<T>((zh_dot - zh * (zz_dot / zz)) / zz, a.yaw);
  return {.x_rad = slope_dot.x() / (T(1) + slope.x() * slope.x()),
          .y_rad = -slope_dot.y() / (T(1) + slope.y() * slope.y())};
}

template <typename T>
Tilt<T> tilt_rate_of(const Euler<T>& attitude, const Vector<T, 3>& rate_b_rad_s) {
  return tilt_rate_of(attitude_sin_cos(attitude), rate_b_rad_s);
}

/// Yaw rate of the z-y-x angles at these body rates: psi' = (q sin(roll) + r cos(roll)) / cos(pitch).
template <typename T>
T yaw_rate_of(const AttitudeSinCos<T>& a, const Vector<T, 3>& rate_b_rad_s) {
  return (rate_b_rad_s.y() * a.roll.sine + rate_b_rad_s.z() * a.roll.cosine) / a.pitch.cosine;
}

}  // namespace m100::core
