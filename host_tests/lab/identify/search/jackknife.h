// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/search/family.h"

namespace m100::lab::identify {

/// The numbers of a fit whose spread is asked for: always as many for the same structure.
using Coordinates = std::function<std::vector<double>(const Fit&)>;

/// More groups say no more about a spread that one of thirty-nine degrees of freedom does not.
inline constexpr std::size_t kMostRefits = 40;

/// 95 % intervals of a fit's coordinates, in their order, by the jackknife: the blocks are cut into groups of
/// neighbours, the structure is fitted again (warm) with one group left out after the other, and the spread of these
/// fits, times Student's t for one degree of freedom less than there are groups, stands to either side of the value.
/// A block bootstrap of ten blocks is too narrow even when widened by Student's t, and costs ten times as much.
/// @param refits  at most so many groups, kMostRefits in any case; below two every interval is its value alone
/// Precondition: `fit` was made by `family` from all its blocks. Cost: one warm fit for each group.
std::vector<Interval> jackknife(const Family& family, const Fit& fit, const Coordinates& coordinates,
                                std::size_t refits);

}  // namespace m100::lab::identify
