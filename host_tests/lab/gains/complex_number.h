// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace m100::lab::gains {

inline double square(double x) { return x * x; }

/// A complex number over any real type R that has + - * / and exp, sin, cos: double, intervals, derivatives.
template <typename R>
struct ComplexNumber {
  R re{};
  R im{};

  friend ComplexNumber operator+(const ComplexNumber& a, const ComplexNumber& b) { return {a.re + b.re, a.im + b.im}; }
  friend ComplexNumber operator-(const ComplexNumber& a, const ComplexNumber& b) { return {a.re - b.re, a.im - b.im}; }
  friend ComplexNumber operator*(const ComplexNumber& a, const ComplexNumber& b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
  }
  friend ComplexNumber operator*(const R& a, const ComplexNumber& b) { return {a * b.re, a * b.im}; }
  friend ComplexNumber operator/(const ComplexNumber& a, const ComplexNumber& b) {
    const R norm = square(b.re) + square(b.im);
    return {(a.re * b.re + a.im * b.im) / norm, (a.im * b.re - a.re * b.im) / norm};
  }
};

template <typename R>
ComplexNumber<R> conjugate(const ComplexNumber<R>& a) {
  return {a.re, R{} - a.im};
}

template <typename R>
ComplexNumber<R> exponential(const ComplexNumber<R>& a) {
  using std::cos, std::exp, std::sin;
  const R size = exp(a.re);
  return {size * cos(a.im), size * sin(a.im)};
}

}  // namespace m100::lab::gains
