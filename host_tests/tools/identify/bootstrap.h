// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host_tests/tools/identify/selection.h"

namespace m100::tools::identify {

/// 95 % intervals of a fit's parameters, in the family's order: blocks are drawn with replacement, the structure is
/// fitted again (warm), and the 2.5 % and 97.5 % quantiles are taken, widened as Student's t widens a
/// normal interval of n blocks.
std::vector<Interval> bootstrap(const Family& family, const Fit& fit, std::size_t draws, std::uint64_t seed);

}  // namespace m100::tools::identify
