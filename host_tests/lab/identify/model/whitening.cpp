// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/whitening.h"

#include <algorithm>
#include <cmath>

namespace m100::lab::identify {

Ar autoregression(const Rows& values, const std::vector<Segment>& segments) {
  Eigen::Matrix<double, kArOrder, kArOrder> normal = Eigen::Matrix<double, kArOrder, kArOrder>::Zero();
  Ar right = Ar::Zero();
  for (const Segment& segment : segments) {
    for (Eigen::Index row = segment.begin + kArOrder; row < segment.end; ++row) {
      const Ar past = values.segment<kArOrder>(row - kArOrder).reverse();
      normal.noalias() += past * past.transpose();
      right.noalias() += past * values(row);
    }
  }
  normal.diagonal().array() += 1e-6 * normal.trace() + 1e-300;
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

double whitened_score(const Rows& values, const std::vector<Segment>& segments) {
  const double count = whitened_rows(segments);
  Rows white = values;
  whiten(autoregression(values, segments), segments, white);
  return count > 0.0 ? count * std::log(std::max(1e-300, white.squaredNorm() / count)) : 0.0;
}

double evidence_over_stretches(const Columns& slopes, const Rows& error, const std::vector<std::size_t>& stretch,
                               double value) {
  const Rows scale = slopes.colwise().norm().array().max(1e-150).inverse().matrix().transpose();
  const Columns scaled = slopes * scale.asDiagonal();  // the units of the numbers differ by many powers of ten
  const Columns whole = scaled.transpose() * scaled;
  const Eigen::Index number = slopes.cols() - 2;
  double sum = 0.0;
  double squares = 0.0;
  double count = 0.0;
  for (Eigen::Index begin = 0; begin < error.size();) {
    Eigen::Index end = begin;
    while (end < error.size() && stretch[static_cast<std::size_t>(end)] == stretch[static_cast<std::size_t>(begin)]) {
      ++end;
    }
    const auto own = scaled.middleRows(begin, end - begin);
    if (own.squaredNorm() > 0.0) {
      Columns others = whole - own.transpose() * own;
      others.diagonal().array() += 1e-9;
      const Rows moved = others.ldlt().solve(own.transpose() * error.segment(begin, end - begin));
      const double change = scale(number) * moved(number);
      sum += change;
      squares += change * change;
      count += 1.0;
    }
    begin = end;
  }
  const double variance = (count - 1.0) / count * (squares - sum * sum / count);
  if (!(count > 2.0) || !(variance > 0.0)) {
    return 0.0;
  }
  const double degrees = count - 1.0;
  const double wallace = (8.0 * degrees + 1.0) / (8.0 * degrees + 3.0);
  return wallace * wallace * degrees * std::log1p(value * value / variance / degrees);
}

}  // namespace m100::lab::identify
