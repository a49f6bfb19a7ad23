// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/maths.h"

namespace m100::core {

// Two families of frames, one conversion each (paper, III-A):
//   the autopilot's: ground north-east-down (NED), body forward-right-down (FRD);
//   ours:            world north-west-up (NWU),    body forward-left-up (FLU).
// Each is the other turned by pi about x: R = R_x(pi) R_M100, so y and z change sign.

/// Unit quaternion, scalar first, Hamilton convention: v_world = q v_body q*.
template <typename T>
struct Quaternion {
  T w{1};
  T x{0};
  T y{0};
  T z{0};
};

/// Roll, pitch, yaw about x, y, z, composed z-y-x (yaw first), all in rad.
/// In FLU: +roll right side down, +pitch nose down, +yaw counter-clockwise.
template <typename T>
struct Euler {
  T roll_rad{0};
  T pitch_rad{0};
  T yaw_rad{0};
};

/// Whether an angle of a message is at most a turn (2 pi and its rounding); a larger one was meant in degrees. NaN is
/// none.
template <typename T>
constexpr bool is_within_turn(T angle_rad) {
  return angle_rad >= T(-6.2832) && angle_rad <= T(6.2832);
}

/// Converts a vector from the autopilot's frames (NED, FRD) to ours (NWU, FLU) or back: both are the same turn.
template <typename T>
Vector<T, 3> flip_yz(const Vector<T, 3>& v) {
  return {v.x(), -v.y(), -v.z()};
}

/// Converts an attitude from FRD in NED to FLU in NWU, or back.
template <typename T>
Quaternion<T> flip_yz(const Quaternion<T>& q) {
  return {q.w, q.x, -q.y, -q.z};
}

template <typename T>
T yaw_of(const Quaternion<T>& q) {
  return core::atan2(T(2) * (q.x * q.y + q.w * q.z), T(1) - T(2) * (q.y * q.y + q.z * q.z));
}

template <typename T>
Euler<T> euler_of(const Quaternion<T>& q) {
  return {.roll_rad = core::atan2(T(2) * (q.y * q.z + q.w * q.x), T(1) - T(2) * (q.x * q.x + q.y * q.y)),
          .pitch_rad = core::asin(T(2) * (q.w * q.y - q.x * q.z)),
          .yaw_rad = yaw_of(q)};
}

template <typename T>
Quaternion<T> quaternion_of(const Euler<T>& e) {
  const T half = T(0.5);
  const T cr = core::cos(half * e.roll_rad), sr = core::sin(half * e.roll_rad);
  const T cp = core::cos(half * e.pitch_rad), sp = core::sin(half * e.pitch_rad);
  const T cy = core::cos(half * e.yaw_rad), sy = core::sin(half * e.yaw_rad);
  return {.w = cr * cp * cy + sr * sp * sy,
          .x = sr * cp * cy - cr * sp * sy,
          .y = cr * sp * cy + sr * cp * sy,
          .z = cr * cp * sy - sr * sp * cy};
}

/// The rotation matrix of a unit quaternion.
template <typename T>
Matrix<T, 3, 3> rotation_of(const Quaternion<T>& q) {
  Matrix<T, 3, 3> out;
  out << T(1) - T(2) * (q.y * q.y + q.z * q.z), T(2) * (q.x * q.y - q.w * q.z), T(2) * (q.x * q.z + q.w * q.y),
      T(2) * (q.x * q.y + q.w * q.z), T(1) - T(2) * (q.x * q.x + q.z * q.z), T(2) * (q.y * q.z - q.w * q.x),
      T(2) * (q.x * q.z - q.w * q.y), T(2) * (q.y * q.z + q.w * q.x), T(1) - T(2) * (q.x * q.x + q.y * q.y);
  return out;
}

/// The world's up direction in body axes; (0, 0, 1) when level, whatever the heading. `wb` turns body vectors into the
/// world.
template <typename T>
Vector<T, 3> up_in_body(const Quaternion<T>& wb) {
  return rotation_of(wb).row(2).transpose();
}

/// Turns a horizontal vector by yaw: body-heading axes -> world axes. Use -yaw for the inverse.
template <typename T>
Vector<T, 2> rotate(const Vector<T, 2>& v, const SinCos<T>& yaw) {
  return {yaw.cosine * v.x() - yaw.sine * v.y(), yaw.sine * v.x() + yaw.cosine * v.y()};
}
template <typename T>
Vector<T, 2> rotate_by_yaw(const Vector<T, 2>& v, T yaw_rad) {
  return rotate(v, sin_cos_of(yaw_rad));
}

}  // namespace m100::core
