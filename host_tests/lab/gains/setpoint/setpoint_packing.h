// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/gains/setpoint/setpoint_tree.h"

namespace m100::lab::gains {

/// Packs up to three planes into each node of the table, so that the longest path has the fewest nodes; writes nodes,
/// planes and depth of `out`. Throws TooLarge if there are more nodes than a table file can hold.
void pack_planes(const std::vector<SplitPlane>& split, SetpointRows& out);

}  // namespace m100::lab::gains
