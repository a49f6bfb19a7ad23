// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/score_test.h"

#include <algorithm>
#include <cmath>

namespace m100::lab::identify {

ScoreTest::ScoreTest(const FreeRun& run, const WhitenedFit& fit, std::span<const FreeParameter> free_parameters)
    : run_(run), offset_(fit.offset), error_(run.error(fit.before).array() - fit.offset) {
  filter_ = autoregression(error_, run.segments());
  white_ = error_;
  run.whiten_rows(filter_, white_);
  own_.resize(error_.size(), static_cast<Eigen::Index>(free_parameters.size()) + 1);
  for (std::size_t k = 0; k < free_parameters.size(); ++k) {
    model::StickAxis moved = fit.before;
    double& value = moved.*free_parameters[k].member;
    value +=
        value + free_parameters[k].step <= free_parameters[k].high ? free_parameters[k].step : -free_parameters[k].step;
    own_.col(static_cast<Eigen::Index>(k)) = difference_to(run.error(moved));
  }
  own_.rightCols(1).setOnes();
  run.whiten_rows(filter_, own_.rightCols(1));
  for (Eigen::Index k = 0; k < own_.cols(); ++k) {
    for (int twice = 0; twice < 2; ++twice) {  // one pass loses digits where columns are nearly parallel
      own_.col(k) -= own_.leftCols(k) * (own_.leftCols(k).transpose() * own_.col(k)).eval();
    }
    const double length = own_.col(k).norm();
    own_.col(k) *= length > 0.0 ? 1.0 / length : 0.0;
  }
  white_ -= own_ * (own_.transpose() * white_).eval();
}

double ScoreTest::statistic(const Rows& error) const {
  constexpr double kParallel = 1e-9;  // of the power; below it the own parameters can make the same step
  Rows step = difference_to(error);
  const double whole = step.squaredNorm();
  step -= own_ * (own_.transpose() * step).eval();
  const double power = step.squaredNorm() * white_.squaredNorm();
  if (!(step.squaredNorm() > kParallel * whole) || !(power > 0.0)) {
    return 0.0;
  }
  const double along = step.dot(white_);
  return -whitened_rows(run_.segments()) * std::log1p(-std::min(1.0 - 1e-12, along * along / power));
}

Rows ScoreTest::difference_to(const Rows& error) const {
  Rows out = error.array() - offset_;
  out -= error_;
  run_.whiten_rows(filter_, out);
  return out;
}

}  // namespace m100::lab::identify
