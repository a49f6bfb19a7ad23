// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>

#include "firmware/core/eigen.h"
// After our eigen.h, which redirects the checks.

namespace m100::sysid {

/// At most this many free parameters in one fit.
inline constexpr int kMaxParameters = 16;

/// Bounds of one parameter. A positive parameter is fitted as its logarithm, which is what the caller makes of it.
struct Box {
  double low;
  double high;
  double step;  ///< of the numerical derivative
};

struct LmReport {
  double sum_of_squares = 0.0;
  int iterations = 0;
  int evaluations = 0;
};

struct LmOptions {
  int iterations = 20;
  double tolerance = 1e-4;  ///< relative decrease of the sum of squares that ends the search
};

/// Minimises |residual(x)|^2 inside a box, by Levenberg-Marquardt with a one-sided numerical Jacobian.
///
/// @param residual  callable (std::span<const double> x, std::span<double> out): fills `out`, finite numbers only
/// @param x         start, and the answer
/// @param scratch   (x.size() + 2) * rows doubles: two residuals and the Jacobian, column after column
/// Cost per iteration: x.size() + 1 evaluations and rows * x.size()^2 / 2 multiplications. Never leaves the box, never
/// returns a worse point than it was given.
template <typename Residual>
LmReport levenberg_marquardt(Residual&& residual, std::span<double> x, std::span<const Box> box, std::size_t rows,
                             std::span<double> scratch, const LmOptions& options) {
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxParameters, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxParameters, kMaxParameters>;
  const int n = static_cast<int>(x.size());
  M100_ASSERT(n <= kMaxParameters && scratch.size() >= (x.size() + 2) * rows);
  std::span<double> now = scratch.subspan(0, rows);
  std::span<double> trial = scratch.subspan(rows, rows);
  const auto column = [&](int j) { return scratch.subspan((static_cast<std::size_t>(j) + 2) * rows, rows); };
  const auto sum = [](std::span<const double> values) {
    double total = 0.0;
    for (const double value : values) {
      total += value * value;
    }
    return total;
  };

  LmReport report;
  residual(std::span<const double>(x), now);
  report.sum_of_squares = sum(now);
  report.evaluations = 1;
  double lambda = 1e-3;
  Vector before(n);
  for (report.iterations = 0; report.iterations < options.iterations; ++report.iterations) {
    for (int j = 0; j < n; ++j) {
      const std::size_t at = static_cast<std::size_t>(j);
      const double kept = x[at];
      const double step = kept + box[at].step <= box[at].high ? box[at].step : -box[at].step;
      x[at] = kept + step;
      residual(std::span<const double>(x), column(j));
      x[at] = kept;
      for (std::size_t row = 0; row < rows; ++row) {
        column(j)[row] = (column(j)[row] - now[row]) / step;
      }
    }
    report.evaluations += n;
    Matrix hessian(n, n);
    Vector gradient(n);
    for (int i = 0; i < n; ++i) {
      const std::span<const double> ci = column(i);
      for (int j = 0; j <= i; ++j) {
        const std::span<const double> cj = column(j);
        double dot = 0.0;
        for (std::size_t row = 0; row < rows; ++row) {
          dot += ci[row] * cj[row];
        }
        hessian(i, j) = hessian(j, i) = dot;
      }
      double dot = 0.0;
      for (std::size_t row = 0; row < rows; ++row) {
        dot += ci[row] * now[row];
      }
      gradient(i) = dot;
    }
    for (int i = 0; i < n; ++i) {
      before(i) = x[static_cast<std::size_t>(i)];
    }
    bool better = false;
    double decrease = 0.0;
    for (int attempt = 0; attempt < 8 && !better; ++attempt) {
      Matrix damped = hessian;
      for (int i = 0; i < n; ++i) {
        damped(i, i) += lambda * hessian(i, i) + 1e-300;
        // A parameter at its bound whose gradient pushes outwards takes no part.
        const std::size_t at = static_cast<std::size_t>(i);
        const bool stuck =
            (before(i) <= box[at].low && gradient(i) > 0.0) || (before(i) >= box[at].high && gradient(i) < 0.0);
        if (stuck || !(hessian(i, i) > 0.0)) {
          damped.row(i).setZero();
          damped.col(i).setZero();
          damped(i, i) = 1.0;
        }
      }
      Vector right = gradient;
      for (int i = 0; i < n; ++i) {
        const std::size_t at = static_cast<std::size_t>(i);
        if ((before(i) <= box[at].low && gradient(i) > 0.0) || (before(i) >= box[at].high && gradient(i) < 0.0)) {
          right(i) = 0.0;
        }
      }
      const Vector delta = damped.ldlt().solve(right);
      for (int i = 0; i < n; ++i) {
        const std::size_t at = static_cast<std::size_t>(i);
        const double wanted = before(i) - delta(i);
        x[at] = wanted < box[at].low ? box[at].low : (wanted > box[at].high ? box[at].high : wanted);
        if (!(x[at] == x[at])) {
          x[at] = before(i);
        }
      }
      residual(std::span<const double>(x), trial);
      ++report.evaluations;
      const double sum_trial = sum(trial);
      if (sum_trial < report.sum_of_squares) {
        better = true;
        decrease = report.sum_of_squares - sum_trial;
        report.sum_of_squares = sum_trial;
        for (std::size_t row = 0; row < rows; ++row) {
          now[row] = trial[row];
        }
        lambda = lambda > 1e-8 ? lambda * 0.2 : lambda;
      } else {
        lambda *= 6.0;
      }
    }
    if (!better) {
      for (int i = 0; i < n; ++i) {
        x[static_cast<std::size_t>(i)] = before(i);
      }
      return report;
    }
    if (decrease < options.tolerance * report.sum_of_squares) {
      ++report.iterations;
      return report;
    }
  }
  return report;
}

}  // namespace m100::sysid
