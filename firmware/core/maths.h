// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace m100::core {

// Elementary functions that give the same bits on every machine (promise R6). They use only + - * / and the square
// root, because IEEE 754 defines their rounding; libm's functions differ between newlib, glibc on armhf and glibc on
// x86-64.
// T is float or double, each in its own arithmetic (some FPUs have float alone); beyond 400 rad float uses double.
// Accuracy, measured: firmware/RESULTS.md. Cost: no loops, 30 to 100 instructions.

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree_rad = kPi / 180.0;
inline constexpr double kRadian_deg = 180.0 / kPi;

/// Largest angle, in rad, that the functions of an angle accept.
inline constexpr double kLargestAngle_rad = 1e5;

/// Sine and cosine of an angle in rad, |angle| <= kLargestAngle_rad; larger or non-finite arguments give NaN.
template <typename T>
T sin(T angle_rad);
template <typename T>
T cos(T angle_rad);
/// Sine and cosine of one angle, with the same bits as two calls of sin() and cos() give, at less cost.
template <typename T>
struct SinCos {
  T sine{0};
  T cosine{1};
};
template <typename T>
SinCos<T> sin_cos_of(T angle_rad);
/// Tangent as sine over cosine; |angle| < pi/2 is the caller's responsibility.
template <typename T>
T tan(T angle_rad);
/// Angle of the vector (x, y), from -pi to pi, in rad; atan2(0, 0) = 0, and a zero y of either sign with a negative x
/// is +pi. Non-finite arguments give NaN.
template <typename T>
T atan2(T y, T x);
/// Arc sine in rad, argument clamped to [-1, 1]; NaN gives NaN.
template <typename T>
T asin(T value);
/// Exponential, argument clamped to [-80, 80]; NaN gives NaN.
template <typename T>
T exp(T value);
/// Correctly rounded square root; negative arguments and NaN give 0.
template <typename T>
T sqrt(T value) {
  return value > T(0) ? std::sqrt(value) : T(0);
}

template <typename T>
constexpr T clamp(T value, T low, T high) {
  return value < low ? low : (value > high ? high : value);
}

/// The angle wrapped into (-pi, pi], with pi rounded to T; |angle| <= kLargestAngle_rad, others give NaN. An angle that
/// is already inside is returned unchanged.
template <typename T>
T wrap_pi(T angle_rad);

}  // namespace m100::core
