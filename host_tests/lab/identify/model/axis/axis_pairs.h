// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "firmware/core/eigen.h"
#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/identify/model/axis/axis_family.h"
#include "host_tests/lab/identify/model/model_family.h"

namespace m100::lab::identify {

/// How the response changes when an edit takes one of its starting values.
struct EditDirection {
  std::string edit;
  Eigen::VectorXd change;
};

/// The `count` pairs of different edits whose directions, each taken forwards, explain most of the residual together,
/// beside the model's own parameters. Shapes: residual and every change have one value for each sample, base has a
/// column for each parameter. Cost: the samples times the square of the number of directions.
std::vector<Family::HiddenPair> best_pairs(const Eigen::VectorXd& residual, const Eigen::MatrixXd& base,
                                           const std::vector<EditDirection>& directions, std::size_t count);

/// The best pairs of a family's edits around a fit. Cost: one simulation for each start of each edit.
std::vector<Family::HiddenPair> pairs_around(const AxisFamily& family, const AxisBlocks& training, const Fit& from);

}  // namespace m100::lab::identify
