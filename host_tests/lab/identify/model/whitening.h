// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "firmware/core/eigen.h"
// Included after firmware/core/eigen.h, which makes Eigen's assertions call ours.
#include <Eigen/Cholesky>

namespace m100::lab::identify {

// Air and autopilot leave a coloured residual. An autoregression of order 4 on rows that are 50 ms or more apart makes
// it white; only then are likelihood ratios between models valid.

using Rows = Eigen::VectorXd;
using Columns = Eigen::MatrixXd;

inline constexpr Eigen::Index kArOrder = 4;
using Ar = Eigen::Matrix<double, kArOrder, 1>;  ///< weight of the value 1, 2, 3, 4 rows ago

/// Rows that follow each other without a gap: [begin, end).
struct Segment {
  Eigen::Index begin = 0;
  Eigen::Index end = 0;
};

/// Least-squares autoregression within the segments. Precondition: the rows are finite.
/// @param regularisation  share of the trace of the normal matrix that is added to each of its diagonal elements
Ar autoregression(const Rows& values, const std::vector<Segment>& segments, double regularisation = 1e-6);

/// Replaces each value by its innovation: the value minus the filter's prediction. The first kArOrder rows of a segment
/// become zero.
void whiten(const Ar& filter, const std::vector<Segment>& segments, Eigen::Ref<Rows> values);

/// Number of rows with an innovation: all but the first kArOrder of each segment.
double whitened_rows(const std::vector<Segment>& segments);

}  // namespace m100::lab::identify
