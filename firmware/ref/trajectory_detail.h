// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/maths.h"
#include "firmware/ref/trajectory.h"

// Shared by the sources of Trajectory only.
namespace m100::ref {

enum AxisIndex : std::size_t { kX, kY, kZ, kYaw };
inline constexpr double kMinPiece_s = 0.2;
inline constexpr double kMaxPiece_s = 3600.0;

template <typename T>
bool usable(const Waypoint<T>& place) {
  constexpr double kFarthest_m = 1000.0;
  const auto inside = [](T value, double limit) { return value <= T(limit) && value >= T(-limit); };
  return inside(place.position_w_m.x(), kFarthest_m) && inside(place.position_w_m.y(), kFarthest_m) &&
         inside(place.position_w_m.z(), kFarthest_m) && inside(place.yaw_rad, 100.0);
}

inline bool usable(const SpeedLimits& limits) {
  return limits.speed_m_s >= 0.01 && limits.acceleration_m_s2 >= 0.01 && limits.yaw_rate_rad_s >= 0.01 &&
         limits.tilt_rad >= 0.01 && limits.speed_m_s <= 100.0 && limits.acceleration_m_s2 <= 100.0 &&
         limits.yaw_rate_rad_s <= 100.0 && limits.tilt_rad <= 1.2;
}

inline core::Duration duration_of(double duration_s) {
  return core::Duration(static_cast<core::Duration::rep>(duration_s * 1e6 + 0.999));
}

template <typename T>
Polynomial<T> narrowed(const Polynomial<double>& from) {
  Polynomial<T> to;
  for (std::size_t i = 0; i < kCoefficients; ++i) {
    to.c[i] = static_cast<T>(from.c[i]);
  }
  return to;
}

template <typename T>
std::array<double, kDimensions> coordinates(const Waypoint<T>& place) {
  return {static_cast<double>(place.position_w_m.x()), static_cast<double>(place.position_w_m.y()),
          static_cast<double>(place.position_w_m.z()), static_cast<double>(place.yaw_rad)};
}

template <typename T>
Waypoint<T> waypoint(const std::array<double, kDimensions>& at) {
  Waypoint<T> place;
  place.position_w_m = {static_cast<T>(at[kX]), static_cast<T>(at[kY]), static_cast<T>(at[kZ])};
  place.yaw_rad = static_cast<T>(at[kYaw]);
  return place;
}

/// yaw_rad plus whole turns, nearest to from_rad.
inline double near(double yaw_rad, double from_rad) { return from_rad + core::wrap_pi(yaw_rad - from_rad); }

inline double larger(double a, double b) { return a > b ? a : b; }

inline double distance(const std::array<double, kDimensions>& a, const std::array<double, kDimensions>& b) {
  double sum = 0.0;
  for (const std::size_t i : {kX, kY, kZ}) {
    sum += (a[i] - b[i]) * (a[i] - b[i]);
  }
  return core::sqrt(sum);
}

}  // namespace m100::ref
