// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/search/family.h"

namespace m100::lab::identify {

/// The numbers of a fit whose spread is asked for: always as many for the same structure.
using Coordinates = std::function<std::vector<double>(const Fit&)>;

/// 95 % intervals of a fit's coordinates, in their order: blocks are drawn with replacement, the structure is fitted
/// again (warm), and the 2.5 % and 97.5 % quantiles are taken, widened as Student's t widens a normal interval of n
/// blocks. Every interval contains its value. Without draws it is the value alone.
/// Precondition: `fit` was made by `family` from all its blocks. Cost: one warm fit for each draw.
std::vector<Interval> bootstrap(const Family& family, const Fit& fit, const Coordinates& coordinates, std::size_t draws,
                                std::uint64_t seed);

}  // namespace m100::lab::identify
