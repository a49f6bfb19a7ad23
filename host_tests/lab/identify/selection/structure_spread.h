// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/selection/problem.h"

namespace m100::lab::identify {

/// Standard deviations of a fit's coordinates that come from the choice of its structure, in the order of
/// Problem::coordinates(): the weighted root mean square of the distances of the alternatives' coordinates from the
/// fit's. The fit has the weight 1, an alternative exp(c / 2), where c (at most 40) is by how much its information
/// criterion on whitened residuals is better. (Model averaging: Burnham and Anderson, Model Selection and Multimodel
/// Inference, 2002, 4.3.)
/// @param alternatives  fits of other structures to the same blocks. Cost: one simulation for each.
std::vector<double> structure_spread(const Problem& problem, const Fit& fit, const std::vector<Fit>& alternatives);

}  // namespace m100::lab::identify
