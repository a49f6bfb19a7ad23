// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

namespace m100::core {

/// The box that a flight must not leave, in the world of the pose (m): x, y, z.
struct Fence {
  struct Side {
    double low_m = -1e6;
    double high_m = 1e6;
  };
  std::array<Side, 3> side{};
  /// Wind speed that the fence allows for. Its gusts use a part of the tilt that braking needs.
  double wind_m_s = 5.0;

  static constexpr std::size_t kX = 0;
  static constexpr std::size_t kY = 1;
  static constexpr std::size_t kZ = 2;
};

}  // namespace m100::core
