// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::lab::gains {

inline double square(double x) { return x * x; }

/// A complex number over a real type R with + - *: double, or a TaylorModel, which has a reciprocal() of its own.
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
  friend ComplexNumber operator/(const ComplexNumber& a, const ComplexNumber& b) { return a * reciprocal(b); }
};

template <typename R>
ComplexNumber<R> reciprocal(const ComplexNumber<R>& a) {
  const R norm = square(a.re) + square(a.im);
  return {a.re / norm, (R{} - a.im) / norm};
}

}  // namespace m100::lab::gains
