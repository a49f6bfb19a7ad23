// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/whitening.h"

#include <algorithm>

namespace m100::lab::identify {

Ar autoregression(const Rows& values, const std::vector<Segment>& segments, double regularisation) {
  Eigen::Matrix<double, kArOrder, kArOrder> normal = Eigen::Matrix<double, kArOrder, kArOrder>::Zero();
  Ar right = Ar::Zero();
  for (const Segment& segment : segments) {
    for (Eigen::Index row = segment.begin + kArOrder; row < segment.end; ++row) {
      const Ar past = values.segment<kArOrder>(row - kArOrder).reverse();
      normal.noalias() += past * past.transpose();
      right.noalias() += past * values(row);
    }
  }
  normal.diagonal().array() += regularisation * normal.trace() + 1e-300;
  return normal.ldlt().solve(right);
}

void whiten(const Ar& filter, const std::vector<Segment>& segments, Eigen::Ref<Rows> values) {
  for (const Segment& segment : segments) {
    for (Eigen::Index row = segment.end - 1; row >= segment.begin; --row) {
      double foretold = 0.0;
      for (Eigen::Index lag = 1; lag <= kArOrder && row - lag >= segment.begin; ++lag) {
        foretold += filter(lag - 1) * values(row - lag);
      }
      values(row) = row < segment.begin + kArOrder ? 0.0 : values(row) - foretold;
    }
  }
}

double whitened_rows(const std::vector<Segment>& segments) {
  double count = 0.0;
  for (const Segment& segment : segments) {
    count += static_cast<double>(std::max<Eigen::Index>(0, segment.end - segment.begin - kArOrder));
  }
  return count;
}

}  // namespace m100::lab::identify
