// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/selection/problem.h"

namespace m100::lab::identify {

/// Standard deviations of a fit's coordinates that come from the choice of its structure, in the order of
/// Problem::coordinates(). The fit has the weight 1, an alternative exp(c / 2), where c (at most 40) is by how much it
/// is better on whitened residuals with the penalty of its parameters; the spread is the weighed root mean square of
/// how far they move the coordinate. (Model averaging: Burnham and Anderson, Model Selection and Multimodel Inference,
/// 2002, 4.3.) A delay that is too short to be named moves a frequency by several per cent: no other interval has this.
/// @param alternatives  fits of other structures to the same blocks. Cost: one simulation for each.
std::vector<double> structure_spread(const Problem& problem, const Fit& fit, const std::vector<Fit>& alternatives);

}  // namespace m100::lab::identify
