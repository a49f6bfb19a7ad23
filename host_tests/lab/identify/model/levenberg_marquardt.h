// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

#include "firmware/core/assert.h"
#include "firmware/core/eigen.h"

namespace m100::lab::identify {

/// Largest number of free parameters in one fit.
inline constexpr int kMaxParameters = 16;

/// Bounds of one fitted number; the caller may fit the logarithm of a positive parameter.
struct Box {
  double low;
  double high;
  double step;  ///< of the numerical derivative
};

struct LmOptions {
  int iterations = 20;
  double tolerance = 1e-4;  ///< relative decrease of the sum of squares that ends the search
};

/// One search by Levenberg-Marquardt; see levenberg_marquardt().
template <typename Residual>
class LmSearch {
 public:
  LmSearch(Residual& residual, std::span<double> x, std::span<const Box> box, std::size_t rows,
           std::span<double> scratch)
      : residual_(residual), x_(x), box_(box), rows_(rows), scratch_(scratch) {
    M100_ASSERT(x.size() <= kMaxParameters && box.size() >= x.size() && scratch.size() >= (x.size() + 2) * rows);
  }

  double run(const LmOptions& options) {
    residual_(std::span<const double>(x_), now());
    sum_of_squares_ = dot(now(), now());
    for (int iteration = 0; iteration < options.iterations; ++iteration) {
      differentiate();
      linearise();
      const double before = sum_of_squares_;
      if (!descend() || before - sum_of_squares_ < options.tolerance * sum_of_squares_) {
        break;
      }
    }
    return sum_of_squares_;
  }

 private:
  using Index = Eigen::Index;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxParameters, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxParameters, kMaxParameters>;
  static constexpr int kAttempts = 8;  ///< dampings tried for one linearisation

  std::span<double> now() const { return scratch_.subspan(0, rows_); }
  std::span<double> trial() const { return scratch_.subspan(rows_, rows_); }
  std::span<double> column(std::size_t j) const { return scratch_.subspan((j + 2) * rows_, rows_); }
  double dot(std::span<const double> a, std::span<const double> b) const {
    std::array<double, 4> totals{};  // four independent sums, because a single sum would wait for each addition
    std::size_t row = 0;
    for (; row + totals.size() <= rows_; row += totals.size()) {
      for (std::size_t k = 0; k < totals.size(); ++k) {
        totals[k] += a[row + k] * b[row + k];
      }
    }
    for (; row < rows_; ++row) {
      totals[0] += a[row] * b[row];
    }
    return (totals[0] + totals[1]) + (totals[2] + totals[3]);
  }

  /// The Jacobian at x by one-sided differences that stay in the box.
  void differentiate() {
    for (std::size_t j = 0; j < x_.size(); ++j) {
      const double kept = x_[j];
      const double step = kept + box_[j].step <= box_[j].high ? box_[j].step : -box_[j].step;
      x_[j] = kept + step;
      residual_(std::span<const double>(x_), column(j));
      x_[j] = kept;
      for (std::size_t row = 0; row < rows_; ++row) {
        column(j)[row] = (column(j)[row] - now()[row]) / step;
      }
    }
  }

  /// Computes J'J and J'r at x, and keeps x as the starting point of every attempt.
  void linearise() {
    const auto n = static_cast<Index>(x_.size());
    hessian_.resize(n, n);
    gradient_.resize(n);
    from_.resize(n);
    for (Index i = 0; i < n; ++i) {
      const std::span<const double> ci = column(static_cast<std::size_t>(i));
      for (Index j = 0; j <= i; ++j) {
        hessian_(i, j) = hessian_(j, i) = dot(ci, column(static_cast<std::size_t>(j)));
      }
      gradient_(i) = dot(ci, now());
      from_(i) = x_[static_cast<std::size_t>(i)];
    }
  }

  /// Whether a parameter is at its bound and descent points out of the box; such a parameter is not moved.
  bool is_stuck(Index i) const {
    const Box& box = box_[static_cast<std::size_t>(i)];
    return (from_(i) <= box.low && gradient_(i) > 0.0) || (from_(i) >= box.high && gradient_(i) < 0.0);
  }

  /// Moves x one damped step from `from_`, inside the box.
  void move() {
    Matrix damped = hessian_;
    Vector right = gradient_;
    for (Index i = 0; i < damped.rows(); ++i) {
      damped(i, i) += damping_ * hessian_(i, i) + 1e-300;
      const bool stuck = is_stuck(i);
      if (stuck || !(hessian_(i, i) > 0.0)) {
        damped.row(i).setZero();
        damped.col(i).setZero();
        damped(i, i) = 1.0;
      }
      if (stuck) {
        right(i) = 0.0;
      }
    }
    const Vector delta = damped.ldlt().solve(right);
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const double start = from_(static_cast<Index>(i));
      const double wanted = start - delta(static_cast<Index>(i));
      x_[i] = wanted == wanted ? std::clamp(wanted, box_[i].low, box_[i].high) : start;
    }
  }

  /// Searches a smaller sum of squares with increasing damping.
  /// @returns whether there was one; if not, x is unchanged.
  bool descend() {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      move();
      residual_(std::span<const double>(x_), trial());
      const double sum = dot(trial(), trial());
      if (sum < sum_of_squares_) {
        sum_of_squares_ = sum;
        std::copy(trial().begin(), trial().end(), now().begin());
        damping_ = damping_ > 1e-8 ? damping_ * 0.2 : damping_;
        return true;
      }
      damping_ *= 6.0;
    }
    for (std::size_t i = 0; i < x_.size(); ++i) {
      x_[i] = from_(static_cast<Index>(i));
    }
    return false;
  }

  Residual& residual_;
  std::span<double> x_;
  std::span<const Box> box_;
  std::size_t rows_;
  std::span<double> scratch_;
  double sum_of_squares_ = 0.0;
  Matrix hessian_;
  Vector gradient_, from_;
  double damping_ = 1e-3;
};

/// Minimises |residual(x)|^2 inside a box, by Levenberg-Marquardt with a one-sided numerical Jacobian.
///
/// @param residual  callable (std::span<const double> x, std::span<double> out): fills `out`, finite numbers only
/// @param x         start, then the result
/// @param scratch   (x.size() + 2) * rows doubles: two residuals and the Jacobian, column after column
/// @returns the sum of squares
/// Cost per iteration: x.size() + 1 evaluations, one more for each rejected step (7 at most), and
/// rows * x.size()^2 / 2 multiplications. Never leaves the box, never returns a worse point than it was given.
template <typename Residual>
double levenberg_marquardt(Residual&& residual, std::span<double> x, std::span<const Box> box, std::size_t rows,
                           std::span<double> scratch, const LmOptions& options) {
  return LmSearch<std::remove_reference_t<Residual>>(residual, x, box, rows, scratch).run(options);
}

}  // namespace m100::lab::identify
