// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace m100::ref {

#ifdef M100_SMALL_MEMORY
inline constexpr std::size_t kMaxNodes = 17;
#else
inline constexpr std::size_t kMaxNodes = 1025;  ///< solving them takes about 175 kB of stack
#endif
inline constexpr std::size_t kDimensions = 4;  ///< x, y, z, yaw

/// A point of a course (m, yaw in rad) with three time derivatives.
struct Node {
  std::array<double, kDimensions> position{};
  std::array<double, kDimensions> velocity{};
  std::array<double, kDimensions> acceleration{};
  std::array<double, kDimensions> jerk{};
};

/// Sets velocity, acceleration and jerk of the nodes so that the integral of the squared snap is minimal; those of the
/// first and the last node to zero. durations_s[i] > 0 is the time from node i to node i + 1.
///
/// The snap of a piece of duration T is a quadratic form in its end states d: T^-7 d~' W d~, d~_k = d_k T^k. Setting
/// the gradient by the inner derivatives to zero gives a block tridiagonal system of 3 x 3 blocks (the unconstrained
/// form of Richter, Bry and Roy, as used by the paper's generator), eliminated once for all four dimensions.
/// Cost: about 600 products per node.
void minimise_snap(std::span<Node> nodes, std::span<const double> durations_s);

}  // namespace m100::ref
