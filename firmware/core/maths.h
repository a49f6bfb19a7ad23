// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace m100::core {

// Elementary functions whose bits are the same on every machine (promise R6). Only + - * / and the square root are
// trusted; libm is not, because its sin, cos and atan2 differ between newlib, glibc on armhf and glibc on x86-64.
// T is float or double.

inline constexpr double kPi = 3.14159265358979323846;

/// Sine and cosine of an angle in rad, |angle| <= 1e5; larger or non-finite arguments give NaN.
template <typename T>
T sin(T angle_rad);
template <typename T>
T cos(T angle_rad);
/// Tangent, |angle| < pi/2 of the caller's responsibility.
template <typename T>
T tan(T angle_rad);
/// Angle of the vector (x, y) in (-pi, pi]; atan2(0, 0) = 0.
template <typename T>
T atan2(T y, T x);
/// Arc sine, argument clamped to [-1, 1].
template <typename T>
T asin(T value);
/// Correctly rounded square root; negative arguments give 0.
template <typename T>
T sqrt(T value) {
  return value > T(0) ? std::sqrt(value) : T(0);
}
/// Exponential, |argument| <= 80.
template <typename T>
T exp(T value);

template <typename T>
constexpr T clamp(T value, T low, T high) {
  return value < low ? low : (value > high ? high : value);
}

/// The same angle in (-pi, pi]. Works for |angle| <= 1e5 rad.
template <typename T>
T wrap_pi(T angle_rad);

}  // namespace m100::core
