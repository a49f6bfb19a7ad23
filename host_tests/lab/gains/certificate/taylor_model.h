// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>

#include "host_tests/lab/gains/complex_number.h"

namespace m100::lab::gains {

/// A function of kCount variables t in [-1, 1], enclosed by its Taylor polynomial of second order and a bound of the
/// rest: |f(t) - constant - linear t - t quadratic t| <= rest. Rounding errors are part of the rest (K. Makino, M.
/// Berz, Taylor models and other validated functional inclusion methods, Int. J. Pure Appl. Math. 4(4), 2003).
template <std::size_t kCount>
struct TaylorModel {
  using Row = std::array<double, kCount>;
  double constant = 0.0;
  Row linear{};
  std::array<Row, kCount> quadratic{};  ///< [i][j] of t_i t_j with i <= j; the others are 0
  double rest = 0.0;

  constexpr TaylorModel() = default;
  constexpr TaylorModel(double exact) : constant(exact) {}  // NOLINT(google-explicit-constructor): a number is one
  /// A constant that is known to within `error`.
  constexpr TaylorModel(double about, double error) : constant(about), rest(error) {}

  static TaylorModel variable(double low, double high, std::size_t which) {
    TaylorModel out(0.5 * (low + high));
    out.linear[which] = kAbove * std::max(high - out.constant, out.constant - low);
    return out;
  }
  double linear_size() const { return sum_of(linear); }
  double quadratic_size() const {
    double sum = 0.0;
    for (const Row& row : quadratic) {
      sum += sum_of(row);
    }
    return sum;
  }
  /// A bound of |f(t) - constant|.
  double reach() const { return kAbove * (linear_size() + quadratic_size() + rest); }
  double size() const { return kAbove * (std::abs(constant) + reach()); }

  /// f(this), from f, f' and f''/2 at the constant, and a bound of the third derivative over 6 within reach().
  TaylorModel chain(double value, double first, double second, double third) const {
    TaylorModel varying = *this;
    varying.constant = 0.0;
    const double reached = reach();
    TaylorModel out = TaylorModel(value) + varying * (TaylorModel(first) + TaylorModel(second) * varying);
    out.rest += kAbove * (third * reached * reached * reached) +
                kFunctionError * (std::abs(value) + reached * (std::abs(first) + reached * std::abs(second)));
    return out;
  }
  friend TaylorModel operator+(const TaylorModel& a, const TaylorModel& b) { return a.plus(b, 1.0); }
  friend TaylorModel operator-(const TaylorModel& a, const TaylorModel& b) { return a.plus(b, -1.0); }
  friend TaylorModel operator*(const TaylorModel& a, const TaylorModel& b) {
    TaylorModel out(a.constant * b.constant);
    for (std::size_t i = 0; i < kCount; ++i) {
      out.linear[i] = a.constant * b.linear[i] + b.constant * a.linear[i];
      out.quadratic[i][i] = a.constant * b.quadratic[i][i] + b.constant * a.quadratic[i][i] + a.linear[i] * b.linear[i];
      for (std::size_t j = i + 1; j < kCount; ++j) {
        out.quadratic[i][j] = a.constant * b.quadratic[i][j] + b.constant * a.quadratic[i][j] +
                              (a.linear[i] * b.linear[j] + a.linear[j] * b.linear[i]);
      }
    }
    const double a1 = a.linear_size(), a2 = a.quadratic_size(), b1 = b.linear_size(), b2 = b.quadratic_size();
    const double a_size = std::abs(a.constant) + a1 + a2, b_size = std::abs(b.constant) + b1 + b2;
    out.rest = kAbove * (a1 * b2 + a2 * b1 + a2 * b2 + a.rest * (b_size + b.rest) + b.rest * a_size +
                         kRoundingError * (a_size * b_size)) +
               kTiny;
    return out;
  }

 private:
  static constexpr double kAbove = 1.0 + 1e-14;  ///< above the errors of up to 40 roundings of a bound
  /// At least twice the rounding errors of four products, their sum, and two factors that were rounded themselves.
  static constexpr double kRoundingError = 8.0 * std::numeric_limits<double>::epsilon();
  static constexpr double kFunctionError = kRoundingError;  ///< of a function of the C library and its derivatives
  static constexpr double kTiny = 1e-300;                   ///< above what is lost below the least normal number

  static double sum_of(const Row& row) {
    double sum = 0.0;
    for (const double number : row) {
      sum += std::abs(number);
    }
    return sum;
  }
  TaylorModel plus(const TaylorModel& b, double sign) const {
    TaylorModel out(constant + sign * b.constant);
    for (std::size_t i = 0; i < kCount; ++i) {
      out.linear[i] = linear[i] + sign * b.linear[i];
      for (std::size_t j = i; j < kCount; ++j) {
        out.quadratic[i][j] = quadratic[i][j] + sign * b.quadratic[i][j];
      }
    }
    out.rest = kAbove * (rest + b.rest +
                         kRoundingError * (std::abs(constant) + std::abs(b.constant) + linear_size() + b.linear_size() +
                                           quadratic_size() + b.quadratic_size())) +
               kTiny;
    return out;
  }
};

template <std::size_t kCount>
TaylorModel<kCount> square(const TaylorModel<kCount>& a) {
  return a * a;
}
template <std::size_t kCount>
TaylorModel<kCount> sin(const TaylorModel<kCount>& a) {
  const double value = std::sin(a.constant);
  return a.chain(value, std::cos(a.constant), -0.5 * value, 1.0 / 5.9);
}
template <std::size_t kCount>
TaylorModel<kCount> cos(const TaylorModel<kCount>& a) {
  const double value = std::cos(a.constant);
  return a.chain(value, -std::sin(a.constant), -0.5 * value, 1.0 / 5.9);
}

/// 1 / a by the first terms of the geometric series about the constant. The rest is infinite if `a` may be 0.
template <std::size_t kCount>
ComplexNumber<TaylorModel<kCount>> reciprocal(const ComplexNumber<TaylorModel<kCount>>& a) {
  using Complex = ComplexNumber<TaylorModel<kCount>>;
  const std::complex<double> first = 1.0 / std::complex<double>(a.re.constant, a.im.constant);
  const Complex scale{first.real(), first.imag()}, one{1.0, 0.0};
  const Complex left = one - scale * a;  // 1/a = scale / (1 - left) = scale (1 + left + left^2 + left^3 / (1 - left))
  const double size = (1.0 + 1e-14) * std::hypot(left.re.size(), left.im.size());
  Complex sum = one + left + left * left;
  const double rest = size < 1.0 ? (1.0 + 1e-14) * size * size * size / (1.0 - size)
                                 : std::numeric_limits<double>::infinity();  // a divisor that may be 0
  sum.re.rest += rest;
  sum.im.rest += rest;
  return scale * sum;
}

}  // namespace m100::lab::gains
