// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/maths.h"

namespace m100::core {

template <typename T>
T sin(T angle_rad) {
  return std::sin(angle_rad);
}
template <typename T>
T cos(T angle_rad) {
  return std::cos(angle_rad);
}
template <typename T>
T tan(T angle_rad) {
  return sin(angle_rad) / cos(angle_rad);
}
template <typename T>
T atan2(T y, T x) {
  return (x == T(0) && y == T(0)) ? T(0) : std::atan2(y, x);
}
template <typename T>
T asin(T value) {
  return std::asin(clamp(value, T(-1), T(1)));
}
template <typename T>
T exp(T value) {
  return std::exp(value);
}
template <typename T>
T wrap_pi(T angle_rad) {
  const T turn = static_cast<T>(2.0 * kPi);
  const T wrapped = angle_rad - turn * std::floor((angle_rad + static_cast<T>(kPi)) / turn);
  return wrapped > static_cast<T>(-kPi) ? wrapped : wrapped + turn;
}

#define M100_INSTANTIATE(T)  \
  template T sin<T>(T);      \
  template T cos<T>(T);      \
  template T tan<T>(T);      \
  template T atan2<T>(T, T); \
  template T asin<T>(T);     \
  template T exp<T>(T);      \
  template T wrap_pi<T>(T);
M100_INSTANTIATE(float)
M100_INSTANTIATE(double)
#undef M100_INSTANTIATE

}  // namespace m100::core
