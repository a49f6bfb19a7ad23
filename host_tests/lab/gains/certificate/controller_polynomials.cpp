// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/certificate/controller_polynomials.h"

#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace m100::lab::gains {
namespace {

using Integers = std::vector<std::vector<mpz_class>>;
using ComplexEnclosure = ComplexNumber<Enclosure>;

/// The least power of two whose product with every number is an integer.
template <typename Dense>
int integer_shift(const Dense& numbers) {
  constexpr int kMantissa = std::numeric_limits<double>::digits;
  int shift = 0;
  for (Eigen::Index i = 0; i < numbers.size(); ++i) {
    const double number = numbers.data()[i];
    shift = number == 0.0 ? shift : std::max(shift, kMantissa - std::ilogb(number));
  }
  return shift;
}

/// number 2^shift, which is an integer.
mpz_class as_integer(double number, int shift) {
  int exponent = 0;
  const double mantissa = std::frexp(number, &exponent);
  constexpr int kMantissa = std::numeric_limits<double>::digits;
  mpz_class out(std::ldexp(mantissa, kMantissa));
  const int left = exponent - kMantissa + shift;
  if (left >= 0) {
    out <<= static_cast<mp_bitcnt_t>(left);
  } else {
    mpz_tdiv_q_2exp(out.get_mpz_t(), out.get_mpz_t(), static_cast<mp_bitcnt_t>(-left));
  }
  return out;
}

/// number 2^-shift, rounded outwards.
Enclosure to_enclosure(const mpz_class& number, long shift) {
  long exponent = 0;
  const double mantissa = mpz_get_d_2exp(&exponent, number.get_mpz_t());  // cuts off
  const double value = std::ldexp(mantissa, static_cast<int>(exponent - shift));
  return number == 0 ? Enclosure(0.0) : Enclosure::outward(value, value, 2.0);
}

mpz_class dot(const std::vector<mpz_class>& a, const std::vector<mpz_class>& b) {
  mpz_class sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    sum += a[k] * b[k];
  }
  return sum;
}

/// rows times columns; `right` is stored by columns.
Integers columns_of(const Integers& left, const Integers& right) {
  Integers out(right.size(), std::vector<mpz_class>(left.size()));
  for (std::size_t column = 0; column < right.size(); ++column) {
    for (std::size_t row = 0; row < left.size(); ++row) {
      out[column][row] = dot(left[row], right[column]);
    }
  }
  return out;
}

/// Coefficients about another point: p(from + d) by powers of d, by repeated division.
std::vector<ComplexEnclosure> about(const std::vector<Enclosure>& polynomial, const ComplexEnclosure& from) {
  std::vector<ComplexEnclosure> out;
  for (const Enclosure& coefficient : polynomial) {
    out.push_back({coefficient, 0.0});
  }
  for (std::size_t k = 0; k + 1 < out.size(); ++k) {
    for (std::size_t i = out.size() - 1; i-- > k;) {
      out[i] = out[i] + from * out[i + 1];
    }
  }
  return out;
}

ComplexEnclosure value_at(const std::vector<ComplexEnclosure>& polynomial, const ComplexEnclosure& d) {
  ComplexEnclosure value = polynomial.back();
  for (std::size_t i = polynomial.size() - 1; i-- > 0;) {
    value = value * d + polynomial[i];
  }
  return value;
}

double size_of(const ComplexEnclosure& number) {
  return (1.0 + 1e-15) * std::hypot(number.re.magnitude(), number.im.magnitude());
}

/// Bounds of a polynomial and its derivative for |d| <= radius. @param first the first power that counts
struct PolynomialBound {
  PolynomialBound(const std::vector<ComplexEnclosure>& polynomial, double radius, std::size_t first) {
    for (std::size_t i = polynomial.size(); i-- > first;) {
      slope = (1.0 + 1e-15) * (slope * radius + static_cast<double>(i) * (i > 0 ? size_of(polynomial[i]) : 0.0));
    }
    double power = std::pow(radius, static_cast<double>(first)) * (1.0 + 1e-14);
    slope = first > 1 ? slope * std::pow(radius, static_cast<double>(first - 1)) * (1.0 + 1e-14) : slope;
    for (std::size_t i = first; i < polynomial.size(); ++i, power *= radius * (1.0 + 1e-15)) {
      value += (1.0 + 1e-15) * size_of(polynomial[i]) * power;
    }
  }
  double value = 0.0, slope = 0.0;
};

/// The first terms of numerator over denominator, as plain numbers.
std::vector<ComplexEnclosure> quotient(const std::vector<ComplexEnclosure>& numerator,
                                       const std::vector<ComplexEnclosure>& denominator) {
  constexpr std::size_t kTerms = 7;
  std::vector<ComplexEnclosure> out;
  for (std::size_t j = 0; j < kTerms; ++j) {
    ComplexEnclosure rest = j < numerator.size() ? numerator[j] : ComplexEnclosure{};
    for (std::size_t i = 1; i <= j && i < denominator.size(); ++i) {
      rest = rest - denominator[i] * out[j - i];
    }
    const ComplexEnclosure term = rest / denominator[0];
    out.push_back({Enclosure(term.re.middle()), Enclosure(term.im.middle())});
  }
  return out;
}

/// numerator - denominator times quotient.
std::vector<ComplexEnclosure> error_of(const std::vector<ComplexEnclosure>& numerator,
                                       const std::vector<ComplexEnclosure>& denominator,
                                       const std::vector<ComplexEnclosure>& quotient) {
  std::vector<ComplexEnclosure> out = numerator;
  out.resize(std::max(numerator.size(), denominator.size() + quotient.size() - 1));
  for (std::size_t i = 0; i < denominator.size(); ++i) {
    for (std::size_t j = 0; j < quotient.size(); ++j) {
      out[i + j] = out[i + j] - denominator[i] * quotient[j];
    }
  }
  return out;
}

std::vector<ComplexEnclosure> derivative(const std::vector<ComplexEnclosure>& polynomial) {
  std::vector<ComplexEnclosure> out;
  for (std::size_t i = 1; i < polynomial.size(); ++i) {
    out.push_back(Enclosure(static_cast<double>(i)) * polynomial[i]);
  }
  return out;
}

ComplexEnclosure widened(const ComplexEnclosure& number, double by) {
  const Enclosure both(-by, by);
  return {number.re + both, number.im + both};
}

}  // namespace

ComplexNumber<LoopJet> point_at(const Enclosure& angle) {
  const LoopJet at = LoopJet::variable(angle, kAngleVariable);
  return {cos(at), sin(at)};
}

ControllerPolynomials::ControllerPolynomials(const LiftedController& controller) {
  const auto n = static_cast<std::size_t>(controller.a.rows());
  const auto inputs = static_cast<std::size_t>(controller.b.cols());
  const int shift = std::max({integer_shift(controller.a), integer_shift(controller.b), integer_shift(controller.c),
                              integer_shift(controller.d)});
  const auto at = [](std::size_t k) { return static_cast<Eigen::Index>(k); };
  Integers a(n, std::vector<mpz_class>(n)), b(inputs, std::vector<mpz_class>(n));
  std::vector<mpz_class> c(n);
  for (std::size_t row = 0; row < n; ++row) {
    for (std::size_t column = 0; column < n; ++column) {
      a[row][column] =
          as_integer(controller.a(at(row), at(column)), shift) - (row == column ? as_integer(1.0, shift) : 0);
    }
    for (std::size_t input = 0; input < inputs; ++input) {
      b[input][row] = as_integer(controller.b(at(row), at(input)), shift);
    }
    c[row] = as_integer(controller.c(at(row)), shift);
  }
  // det(s - A) = sum of p_i s^i and its adjugate, sum of M_k s^(n - k), in integers; s = 2^shift (z - 1).
  std::vector<mpz_class> p(n + 1);
  p[n] = 1;
  std::vector<std::vector<mpz_class>> through(n, std::vector<mpz_class>(inputs));  // c M b, by power
  Integers m(n, std::vector<mpz_class>(n));
  for (std::size_t k = 1; k <= n; ++k) {
    m = k == 1 ? m : columns_of(a, m);
    for (std::size_t i = 0; i < n; ++i) {
      m[i][i] += p[n - k + 1];
    }
    mpz_class trace = 0;
    for (std::size_t i = 0; i < n; ++i) {
      trace += dot(a[i], m[i]);
    }
    p[n - k] = -trace / mpz_class(static_cast<unsigned long>(k));
    std::vector<mpz_class> row(n);
    for (std::size_t column = 0; column < n; ++column) {
      row[column] = dot(c, m[column]);
    }
    for (std::size_t input = 0; input < inputs; ++input) {
      through[n - k][input] = dot(row, b[input]);
    }
  }
  const auto back = [&](std::size_t power) { return static_cast<long>(shift) * static_cast<long>(n - power); };
  numerators_.resize(inputs);
  for (std::size_t power = 0; power <= n; ++power) {
    denominator_.push_back(to_enclosure(p[power], back(power)));
    for (std::size_t input = 0; input < inputs; ++input) {
      mpz_class sum = as_integer(controller.d(at(input)), shift) * p[power];
      sum += power < n ? through[power][input] : mpz_class(0);
      numerators_[input].push_back(to_enclosure(sum, back(power) + shift));
    }
  }
}

ControllerPolynomials::OverArc ControllerPolynomials::over(const Enclosure& angle) const {
  const ComplexNumber<LoopJet> arc = point_at(angle);
  const auto point = [](const Enclosure& of) { return Enclosure(of.middle()); };
  const ComplexEnclosure from{point(arc.re.middle), point(arc.im.middle)};
  const ComplexEnclosure d{arc.re.value - from.re, arc.im.value - from.im};
  const ComplexEnclosure no_d{arc.re.middle - from.re, arc.im.middle - from.im};
  const ComplexEnclosure turn{arc.re.by[kAngleVariable], arc.im.by[kAngleVariable]};
  const ComplexEnclosure start{from.re - Enclosure(1.0), from.im};
  const std::vector<ComplexEnclosure> below = about(denominator_, start);
  const PolynomialBound varying(below, size_of(d), 1);
  const ComplexEnclosure first{point(below[0].re), point(below[0].im)};
  const double least =
      (1.0 - 1e-14) * std::hypot(first.re.low, first.im.low) - size_of(below[0] - first) - varying.value;
  OverArc out{.valid = least > 0.0, .response = {}, .numerators = {}, .denominator = value_at(below, d)};
  for (const std::vector<Enclosure>& numerator : numerators_) {
    const std::vector<ComplexEnclosure> above = about(numerator, start);
    out.numerators.push_back(value_at(above, d));
    if (!out.valid) {
      continue;
    }
    const std::vector<ComplexEnclosure> terms = quotient(above, below);
    const std::vector<ComplexEnclosure> error = error_of(above, below, terms);
    const PolynomialBound over(error, size_of(d), 0), there(error, size_of(no_d), 0);
    constexpr double kAbove = 1.0 + 1e-14;
    const double slope_by = kAbove * (over.slope / least + over.value * varying.slope / (least * least));
    const ComplexEnclosure value = widened(value_at(terms, d), kAbove * over.value / least);
    const ComplexEnclosure middle = widened(value_at(terms, no_d), kAbove * there.value / least);
    const ComplexEnclosure slope = widened(value_at(derivative(terms), d), slope_by) * turn;
    std::array<Enclosure, 4> re{}, im{};
    re[kAngleVariable] = slope.re;
    im[kAngleVariable] = slope.im;
    out.response.push_back({LoopJet(value.re, middle.re, re), LoopJet(value.im, middle.im, im)});
  }
  return out;
}

}  // namespace m100::lab::gains
