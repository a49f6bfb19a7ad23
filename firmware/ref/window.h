// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace m100::ref {

inline constexpr std::size_t kHorizon = 20;       ///< N of the paper, III-E.1
inline constexpr double kPredictionStep_s = 0.1;  ///< of the horizontal MPC

template <typename T>
struct AxisReference {
  T position_m{0};
  T velocity_m_s{0};
  T acceleration_m_s2{0};
};

/// The state after a time of constant jerk.
template <typename T>
AxisReference<T> after(const AxisReference<T>& state, T time_s, T jerk_m_s3) {
  constexpr T kThird = static_cast<T>(1.0 / 3.0);
  const T half_s = T(0.5) * time_s;
  const T slope = state.acceleration_m_s2 + kThird * jerk_m_s3 * time_s;
  return {.position_m = state.position_m + time_s * (state.velocity_m_s + half_s * slope),
          .velocity_m_s = state.velocity_m_s + time_s * (state.acceleration_m_s2 + half_s * jerk_m_s3),
          .acceleration_m_s2 = state.acceleration_m_s2 + jerk_m_s3 * time_s};
}

/// The reference `time_s` after the first point, at most one step before the last one.
template <typename T>
AxisReference<T> between(std::span<const AxisReference<T>> points, T time_s) {
  constexpr T kStep_s = static_cast<T>(kPredictionStep_s);
  std::size_t k = 0;
  for (; k + 2 < points.size() && time_s >= kStep_s; ++k) {
    time_s -= kStep_s;
  }
  const T jerk_m_s3 = (points[k + 1].acceleration_m_s2 - points[k].acceleration_m_s2) / kStep_s;
  return after(points[k], time_s, jerk_m_s3);
}

/// The reference now and over the horizon, world frame. x[k], y[k] are at now + lead + k * 0.1 s, k = 0..20, where lead
/// is what the caller of Trajectory::fill() passed (a transport delay); height and yaw are at now.
template <typename T>
struct Window {
  std::array<AxisReference<T>, kHorizon + 1> x{};
  std::array<AxisReference<T>, kHorizon + 1> y{};
  AxisReference<T> height{};
  T yaw_rad{0};
  T yaw_rate_rad_s{0};
  bool constant = false;  ///< true: one position at rest over the whole horizon; the explicit law may be used
};

}  // namespace m100::ref
