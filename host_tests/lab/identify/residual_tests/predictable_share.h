// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "firmware/core/eigen.h"
#include "host_tests/lab/identify/residual_tests/residual_test.h"

namespace m100::lab::identify {

// Measures how much of a residual a group of regressors predicts, and how much chance alone reaches.

/// Folds of the cross-validation; a residual of fewer blocks cannot be tested.
inline constexpr std::size_t kResidualFolds = 5;

/// Division of the samples into means over several samples, block by block, so that no mean straddles a block.
struct Thinned {
  std::vector<std::size_t> begin;  ///< first sample of each mean
  std::vector<std::size_t> end;
  std::vector<std::size_t> fold;  ///< of the cross-validation; blocks are assigned in turn
};

/// Divides the samples into means at 10 Hz: a residual has little power above 5 Hz, and this rate saves time.
/// Precondition: block_begin of the input ascends from 0 and stays below `samples`.
Thinned thin(const ResidualInput& input, std::size_t samples);
/// The means of `values`, which has one value for each sample. If it has one for each mean, it is returned unchanged.
Eigen::VectorXd mean_of(std::span<const double> values, const Thinned& thinned);

/// For each group the largest cross-validated share of the variance of any target that it predicts; largest share
/// first. ResidualFinding::Share::shifted is the same for all groups: the largest share that any group reaches on any
/// of `shifts` circular shifts of a target, as an estimate of what chance reaches. Shapes: a target has one value for
/// each mean, a group's column one for each sample or mean.
std::vector<ResidualFinding::Share> predictable_shares(const std::vector<Eigen::VectorXd>& targets,
                                                       const std::vector<RegressorGroup>& groups,
                                                       const Thinned& thinned, std::size_t shifts);

}  // namespace m100::lab::identify
