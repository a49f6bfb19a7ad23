// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

namespace m100::ref {

inline constexpr std::size_t kHorizon = 20;       ///< N of the paper, III-E.1
inline constexpr double kPredictionStep_s = 0.1;  ///< of the horizontal MPC

template <typename T>
struct AxisReference {
  T position_m{0};
  T velocity_m_s{0};
  T acceleration_m_s2{0};
};

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
