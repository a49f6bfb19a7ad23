// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/predictable_share.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

// Included after firmware/core/eigen.h, which makes Eigen's assertions call ours.
#include <Eigen/Cholesky>

namespace m100::lab::identify {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr double kWorkRate_hz = 10.0;

/// Ridge regression of many targets on one group, cross-validated; normal equations are made once per fold.
class GroupRegression {
 public:
  GroupRegression(const RegressorGroup& group, const Thinned& thinned) : fold_(thinned.fold) {
    const auto rows = static_cast<Eigen::Index>(thinned.begin.size());
    x_.resize(rows, static_cast<Eigen::Index>(group.columns.size()) + 1);
    x_.col(0).setOnes();
    for (std::size_t k = 0; k < group.columns.size(); ++k) {
      Vector column = mean_of(group.columns[k], thinned);
      const double mean = column.mean();
      column.array() -= mean;
      const double size = std::sqrt(column.squaredNorm() / static_cast<double>(rows));
      x_.col(static_cast<Eigen::Index>(k) + 1) = size > 0.0 ? Vector(column / size) : Vector(Vector::Zero(rows));
    }
    const Matrix all = x_.transpose() * x_;
    for (std::size_t fold = 0; fold < kResidualFolds; ++fold) {
      Matrix kept = all;
      for (Eigen::Index row = 0; row < rows; ++row) {
        if (fold_[static_cast<std::size_t>(row)] == fold) {
          kept.selfadjointView<Eigen::Lower>().rankUpdate(x_.row(row).transpose(), -1.0);
        }
      }
      kept.triangularView<Eigen::StrictlyUpper>() = kept.transpose();
      for (Eigen::Index k = 1; k < kept.rows(); ++k) {
        kept(k, k) += group.ridge * static_cast<double>(rows);
      }
      kept(0, 0) += 1e-9 * static_cast<double>(rows);
      solvers_.emplace_back(kept);
    }
  }

  /// Share of the target's variance that the other folds predict.
  double share(const Vector& target) const {
    const Vector all = x_.transpose() * target;
    std::vector<Vector> left_out(kResidualFolds, Vector::Zero(x_.cols()));
    for (Eigen::Index row = 0; row < x_.rows(); ++row) {
      left_out[fold_[static_cast<std::size_t>(row)]] += x_.row(row).transpose() * target(row);
    }
    std::vector<Vector> weights;
    for (std::size_t fold = 0; fold < kResidualFolds; ++fold) {
      weights.push_back(solvers_[fold].solve(all - left_out[fold]));
    }
    double error = 0.0;
    for (Eigen::Index row = 0; row < x_.rows(); ++row) {
      const double offset = target(row) - x_.row(row).dot(weights[fold_[static_cast<std::size_t>(row)]]);
      error += offset * offset;
    }
    const double mean = target.mean();
    const double spread = (target.array() - mean).square().sum();
    return spread > 0.0 ? 1.0 - error / spread : 0.0;
  }

 private:
  Matrix x_;
  std::vector<std::size_t> fold_;
  std::vector<Eigen::LDLT<Matrix>> solvers_;
};

Vector shifted(const Vector& values, Eigen::Index by) {
  Vector out(values.size());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    out((i + by) % values.size()) = values(i);
  }
  return out;
}

}  // namespace

Thinned thin(const ResidualInput& input, std::size_t samples) {
  const auto factor =
      std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(1.0 / (kWorkRate_hz * input.sample_period_s))));
  Thinned out;
  for (std::size_t block = 0; block < input.block_begin.size(); ++block) {
    const std::size_t stop = block + 1 < input.block_begin.size() ? input.block_begin[block + 1] : samples;
    for (std::size_t at = input.block_begin[block]; at < stop; at += factor) {
      out.begin.push_back(at);
      out.end.push_back(std::min(at + factor, stop));
      out.fold.push_back(block % kResidualFolds);
    }
  }
  return out;
}

Vector mean_of(std::span<const double> values, const Thinned& thinned) {
  if (values.size() == thinned.begin.size()) {
    return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
  }
  Vector out(static_cast<Eigen::Index>(thinned.begin.size()));
  for (std::size_t row = 0; row < thinned.begin.size(); ++row) {
    double sum = 0.0;
    for (std::size_t i = thinned.begin[row]; i < thinned.end[row]; ++i) {
      sum += values[i];
    }
    out(static_cast<Eigen::Index>(row)) = sum / static_cast<double>(thinned.end[row] - thinned.begin[row]);
  }
  return out;
}

std::vector<ResidualFinding::Share> predictable_shares(const std::vector<Vector>& targets,
                                                       const std::vector<RegressorGroup>& groups,
                                                       const Thinned& thinned, std::size_t shifts) {
  std::vector<ResidualFinding::Share> out;
  double bar = 0.0;
  const auto rows = static_cast<Eigen::Index>(thinned.begin.size());
  const Eigen::Index minimum = std::max<Eigen::Index>(1, std::min<Eigen::Index>(rows / 4, 25));
  for (const RegressorGroup& group : groups) {
    const GroupRegression regression(group, thinned);
    ResidualFinding::Share share{group.source, -1.0, 0.0};
    for (const Vector& target : targets) {
      share.predicted = std::max(share.predicted, regression.share(target));
    }
    std::mt19937_64 random(20260101);  // the same shifts for every group
    for (std::size_t shift = 0; shift < shifts; ++shift) {
      const auto span = static_cast<std::uint64_t>(std::max<Eigen::Index>(1, rows - 2 * minimum));
      const Eigen::Index by = minimum + static_cast<Eigen::Index>(random() % span);
      for (const Vector& target : targets) {
        bar = std::max(bar, regression.share(shifted(target, by)));
      }
    }
    out.push_back(share);
  }
  for (ResidualFinding::Share& share : out) {
    share.shifted = bar;
  }
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.predicted > b.predicted; });
  return out;
}

}  // namespace m100::lab::identify
