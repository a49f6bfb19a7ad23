// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host_tests/lab/gains/setpoint_regions.h"

namespace m100::lab::gains {

inline constexpr std::uint16_t kLeaf = mpc::SetpointTree<double>::kLeaf;

/// One plane of the search over the regions.
struct SplitPlane {
  std::vector<double> plane;             ///< kPlaneNumbers, in the table's units; positive on the side of child[1]
  std::array<std::uint16_t, 2> child{};  ///< a plane that stands behind this one, or kLeaf + a row of the laws
};

/// Splits the box along facets until all regions that meet a leaf follow from one clipped affine law, and writes
/// mirror, laws and borders of `out`. Throws TooLarge when a table could not hold the law or the allowance is spent.
/// @returns the planes, the first of the search first; empty where one law is enough: it is then row 0 of the laws.
std::vector<SplitPlane> split_box(const Regions& regions, const ParametricProgram& program, const Undertaking& work,
                                  SetpointRows& out);

/// Puts up to three planes at a time into the nodes of the table, so that the longest path has the fewest nodes; writes
/// nodes, planes and depth of `out`. Throws TooLarge when there are more nodes than a table file holds.
void pack_planes(const std::vector<SplitPlane>& split, SetpointRows& out);

}  // namespace m100::lab::gains
