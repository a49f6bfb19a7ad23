// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/change_scan.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace m100::lab::identify {
namespace {

constexpr double kMiddle = 0.8;
constexpr std::size_t kFilters = 48;
constexpr double kDateDrop = 7.35;  // drop of the ratio whose interval holds the true time in 95 % of simulated logs

/// Regularises each column by itself, because their units differ by many powers of ten.
void make_regular(Columns& normal) {
  normal.diagonal() = normal.diagonal() * (1.0 + 1e-9) + Rows::Constant(normal.rows(), 1e-300);
}

/// Solves a symmetric system that may be singular, because the log may not excite every column.
template <typename Right>
Columns solve(Columns normal, const Right& right) {
  make_regular(normal);
  return normal.ldlt().solve(right);
}

class Scan {
 public:
  Scan(const ScanRows& rows, const Columns& columns) : rows_(rows), columns_(columns) {
    order_.resize(rows.time_s.size());
    std::iota(order_.begin(), order_.end(), 0);
    std::stable_sort(order_.begin(), order_.end(), [&](Eigen::Index a, Eigen::Index b) { return time(a) < time(b); });
    count_ = whitened_rows(rows.segments);
    const double first_s = time(order_.front());
    const double last_s = time(order_.back());
    from_s_ = first_s + 0.5 * (1.0 - kMiddle) * (last_s - first_s);
    to_s_ = last_s - 0.5 * (1.0 - kMiddle) * (last_s - first_s);
    for (const Eigen::Index row : order_) {
      if (time(row) > from_s_ && time(row) < to_s_ && (dates_.empty() || time(row) > dates_.back() + 1e-6)) {
        dates_.push_back(time(row));
      }
    }
  }

  ScanHit run() {
    ScanHit best;
    if (dates_.size() < 2) {
      return best;
    }
    // Each filter is used for the dates around its own.
    const std::size_t pieces = std::min(kFilters, dates_.size());
    for (std::size_t piece = 0; piece < pieces; ++piece) {
      const std::size_t begin = piece * dates_.size() / pieces;
      const std::size_t end = (piece + 1) * dates_.size() / pieces;
      filter_for(dates_[(begin + end) / 2]);
      sweep(begin, end, best);
    }
    for (int pass = 0; pass < 2; ++pass) {
      filter_for(best.at_s);
      const double centre_s = best.at_s;
      best.likelihood_ratio = 0.0;
      const auto near = [&](double s) {
        return static_cast<std::size_t>(std::lower_bound(dates_.begin(), dates_.end(), s) - dates_.begin());
      };
      sweep(near(centre_s - 2.0), near(centre_s + 2.0), best);
    }
    best.low_s = best.high_s = best.at_s;
    for (const double date_s : dates_) {
      if (likelihood_ratio(date_s, nullptr) > best.likelihood_ratio - kDateDrop) {
        best.low_s = std::min(best.low_s, date_s);
        best.high_s = std::max(best.high_s, date_s);
      }
    }
    return best;
  }

 private:
  double time(Eigen::Index row) const { return rows_.time_s[static_cast<std::size_t>(row)]; }

  void sweep(std::size_t begin, std::size_t end, ScanHit& best) const {
    for (std::size_t k = begin; k < end; ++k) {
      Rows size;
      const double value = likelihood_ratio(dates_[k], &size);
      if (value > best.likelihood_ratio) {
        best.likelihood_ratio = value;
        best.at_s = dates_[k];
        best.size = size;
      }
    }
  }

  void whiten_rows(Eigen::Ref<Rows> values) const {
    whiten(filter_, rows_.segments, values);
    if (rows_.weights.size() == values.size()) {
      values.array() *= rows_.weights.array();
    }
  }

  /// Whitens residual, base and columns by the autoregression of the best fit's residual with a change at `date_s`.
  void filter_for(double date_s) {
    const Eigen::Index p = rows_.base.cols();
    const Eigen::Index k = columns_.cols();
    Columns all(rows_.base.rows(), p + k);
    all.leftCols(p) = rows_.base;
    all.rightCols(k) = columns_;
    for (Eigen::Index row = 0; row < all.rows(); ++row) {
      if (time(row) <= date_s) {
        all.row(row).tail(k).setZero();
      }
    }
    const Rows left = rows_.residual - all * solve(all.transpose() * all, all.transpose() * rows_.residual);
    filter_ = autoregression(left, rows_.segments);
    white_residual_ = rows_.residual;
    whiten_rows(white_residual_);
    white_base_ = rows_.base;
    for (Eigen::Index c = 0; c < p; ++c) {
      whiten_rows(white_base_.col(c));
    }
    white_columns_ = columns_;
    for (Eigen::Index c = 0; c < k; ++c) {
      whiten_rows(white_columns_.col(c));
    }
    Columns normal = white_base_.transpose() * white_base_;
    make_regular(normal);
    normal_.compute(normal);
    base_residual_ = white_base_.transpose() * white_residual_;
    base_solution_ = p > 0 ? Rows(normal_.solve(base_residual_)) : Rows(0);
    power_ = white_residual_.squaredNorm() - base_residual_.dot(base_solution_);
    accumulate();
  }

  // For each position in time order, sums over all rows from there to the end: products of the change's columns with
  // themselves, the base and the residual.
  void accumulate() {
    const Eigen::Index k = columns_.cols();
    const Eigen::Index width = k + white_base_.cols() + 1;
    after_.resize(static_cast<Eigen::Index>(order_.size()) + 1, k * width);
    after_.row(after_.rows() - 1).setZero();
    Eigen::RowVectorXd factors(width);
    for (Eigen::Index place = after_.rows() - 2; place >= 0; --place) {
      const Eigen::Index row = order_[static_cast<std::size_t>(place)];
      factors << white_columns_.row(row), white_base_.row(row), white_residual_(row);
      after_.row(place) = after_.row(place + 1);
      for (Eigen::Index c = 0; c < k; ++c) {
        after_.row(place).segment(c * width, width) += white_columns_(row, c) * factors;
      }
    }
  }

  /// Likelihood ratio of a change after `date_s`, with the present filter.
  double likelihood_ratio(double date_s, Rows* size) const {
    const Eigen::Index k = columns_.cols();
    const Eigen::Index p = white_base_.cols();
    const auto place = std::upper_bound(order_.begin(), order_.end(), date_s,
                                        [&](double s, Eigen::Index row) { return s < time(row); });
    Eigen::RowVectorXd sums = after_.row(place - order_.begin());
    Columns own(k, k);
    Columns with_base(k, p);
    Rows with_residual(k);
    const Eigen::Index width = k + p + 1;
    for (Eigen::Index c = 0; c < k; ++c) {
      own.row(c) = sums.segment(c * width, k);
      with_base.row(c) = sums.segment(c * width + k, p);
      with_residual(c) = sums(c * width + k + p);
    }
    correct(date_s, own, with_base, with_residual);
    if (p > 0) {
      own -= with_base * normal_.solve(with_base.transpose());
      with_residual -= with_base * base_solution_;
    }
    const Columns solution = solve(own, with_residual);
    const double share = power_ > 0.0 ? solution.col(0).dot(with_residual) / power_ : 0.0;
    if (size != nullptr) {
      *size = solution.col(0);
    }
    return share > 0.0 ? -count_ * std::log(std::max(1e-12, 1.0 - share)) : 0.0;
  }

  // Corrects the sums for the first rows after the change: a column that begins there whitens to other values
  // than the whole column.
  void correct(double date_s, Columns& own, Columns& with_base, Rows& with_residual) const {
    for (const Segment& segment : rows_.segments) {
      if (time(segment.begin) > date_s || time(segment.end - 1) <= date_s) {
        continue;
      }
      const auto begin = rows_.time_s.begin();
      const Eigen::Index cut = std::upper_bound(begin + segment.begin, begin + segment.end, date_s) - begin;
      for (Eigen::Index row = cut; row < std::min(cut + kArOrder, segment.end); ++row) {
        if (row < segment.begin + kArOrder) {
          continue;
        }
        Eigen::RowVectorXd now = columns_.row(row);
        for (Eigen::Index lag = 1; row - lag >= cut; ++lag) {
          now -= filter_(lag - 1) * columns_.row(row - lag);
        }
        now *= rows_.weights.size() > row ? rows_.weights(row) : 1.0;
        const Eigen::RowVectorXd counted = white_columns_.row(row);
        own += now.transpose() * now - counted.transpose() * counted;
        with_base += (now - counted).transpose() * white_base_.row(row);
        with_residual += (now - counted).transpose() * white_residual_(row);
      }
    }
  }

  const ScanRows& rows_;
  const Columns& columns_;
  std::vector<Eigen::Index> order_;  ///< rows by time
  std::vector<double> dates_;
  double from_s_ = 0.0;
  double to_s_ = 0.0;
  double count_ = 0.0;
  Ar filter_ = Ar::Zero();
  Rows white_residual_;
  Columns white_base_;
  Columns white_columns_;
  Eigen::LDLT<Columns> normal_;
  Rows base_residual_;
  Rows base_solution_;
  double power_ = 0.0;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> after_;
};

}  // namespace

ScanHit scan_change(const ScanRows& rows, const Columns& columns) {
  constexpr std::size_t kMinRows = 40;
  if (rows.time_s.size() < kMinRows || !(columns.squaredNorm() > 0.0)) {
    return {};
  }
  return Scan(rows, columns).run();
}

}  // namespace m100::lab::identify
