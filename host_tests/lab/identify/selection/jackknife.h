// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "host_tests/lab/identify/model/model_family.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify {

/// The numbers of a fit whose spread is estimated; the same count for every fit of one structure.
using Coordinates = std::function<std::vector<double>(const Fit&)>;

/// Largest number of groups. More add nothing: a spread with thirty-nine degrees of freedom is known well enough.
inline constexpr std::size_t kMaxRefits = 40;

/// 95 % intervals of a fit's coordinates, in their order, by the jackknife. The blocks are divided into groups of
/// neighbours, and the structure is fitted again (from the fit's own values) with each group left out in turn. The half
/// width is the jackknife's standard error times Student's t, with one degree of freedom less than there are groups.
/// @param refits  largest number of groups, limited to kMaxRefits; below two the intervals have no width
/// Precondition: `fit` was made by `family` from all its blocks. Cost: one warm fit for each group.
std::vector<Interval> jackknife(const Family& family, const Fit& fit, const Coordinates& coordinates,
                                std::size_t refits);

}  // namespace m100::lab::identify
