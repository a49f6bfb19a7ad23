// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host_tests/lab/gains/setpoint/setpoint_regions.h"

namespace m100::lab::gains {

inline constexpr std::uint16_t kLeaf = mpc::SetpointTree<double>::kLeaf;

/// One plane of the search over the regions.
struct SplitPlane {
  std::vector<double> plane;             ///< kPlaneNumbers, in the table's units; positive on the side of child[1]
  std::array<std::uint16_t, 2> child{};  ///< a later plane, or kLeaf + a row of the laws
};

/// Splits the box along facets until one clipped affine law serves all regions that meet a leaf, and writes mirror,
/// laws and borders of `out`. Throws TooLarge if a table cannot hold the law or the budget is spent.
/// @returns the planes, beginning with the root of the search; empty if one law is enough, which is then row 0.
std::vector<SplitPlane> split_box(const Regions& regions, const ParametricProgram& program,
                                  const ConstructionContext& work, SetpointRows& out);

}  // namespace m100::lab::gains
