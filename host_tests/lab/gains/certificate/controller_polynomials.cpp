// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/certificate/controller_polynomials.h"

#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace m100::lab::gains {
namespace {

using Integers = std::vector<std::vector<mpz_class>>;
using Ball = TaylorModel<1>;  ///< a number with a bound of its error
using ComplexBall = ComplexNumber<Ball>;
using ComplexModel = ComplexNumber<LoopModel>;

/// An exponent (0 or more) with which every number times 2^exponent is an integer.
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

/// number * 2^shift, which is an integer.
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

/// number * 2^-shift, with a bound of its rounding error.
Ball to_ball(const mpz_class& number, long shift) {
  long exponent = 0;
  const double mantissa = mpz_get_d_2exp(&exponent, number.get_mpz_t());  // truncated towards zero
  const double value = std::ldexp(mantissa, static_cast<int>(exponent - shift));
  return {value, 2.0 * std::numeric_limits<double>::epsilon() * std::abs(value)};
}

/// Rows of a matrix of doubles, times 2^shift.
Integers rows_of(const Eigen::MatrixXd& matrix, int shift) {
  Integers out(static_cast<std::size_t>(matrix.rows()));
  for (std::size_t row = 0; row < out.size(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      out[row].push_back(as_integer(matrix(static_cast<Eigen::Index>(row), column), shift));
    }
  }
  return out;
}

void add_to_diagonal(Integers& matrix, const mpz_class& number) {
  for (std::size_t i = 0; i < matrix.size(); ++i) {
    matrix[i][i] += number;
  }
}

mpz_class dot(const std::vector<mpz_class>& a, const std::vector<mpz_class>& b) {
  mpz_class sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    sum += a[k] * b[k];
  }
  return sum;
}

/// The product. `left` is stored by rows; `right` and the result are stored by columns.
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
std::vector<ComplexBall> about(const std::vector<Ball>& polynomial, const ComplexBall& from) {
  std::vector<ComplexBall> out;
  out.reserve(polynomial.size());
  for (const Ball& coefficient : polynomial) {
    out.push_back({coefficient, 0.0});
  }
  for (std::size_t k = 0; k + 1 < out.size(); ++k) {
    for (std::size_t i = out.size() - 1; i-- > k;) {
      out[i] = out[i] + from * out[i + 1];
    }
  }
  return out;
}

ComplexModel value_at(const std::vector<ComplexBall>& polynomial, const ComplexModel& d) {
  ComplexModel value;
  for (std::size_t i = polynomial.size(); i-- > 0;) {
    const auto& [re, im] = polynomial[i];
    value = value * d + ComplexModel{{re.constant, re.rest}, {im.constant, im.rest}};
  }
  return value;
}

template <std::size_t kCount>
double bound_of_size(const ComplexNumber<TaylorModel<kCount>>& number) {
  return (1.0 + 1e-15) * std::hypot(number.re.size(), number.im.size());
}

/// A bound of the sum of the terms of power `first` and higher of a polynomial, for |d| <= radius.
double bound_of(const std::vector<ComplexBall>& polynomial, double radius, std::size_t first) {
  double sum = 0.0;
  for (std::size_t i = polynomial.size(); i-- > 0;) {
    sum = (1.0 + 1e-15) * (sum * radius + (i >= first ? bound_of_size(polynomial[i]) : 0.0));
  }
  return sum;
}

/// The first terms of the series of numerator over denominator, without a bound of their error.
std::vector<ComplexBall> quotient(const std::vector<ComplexBall>& numerator,
                                  const std::vector<ComplexBall>& denominator) {
  constexpr std::size_t kTerms = 7;
  const auto middle = [](const ComplexBall& of) { return std::complex(of.re.constant, of.im.constant); };
  std::vector<std::complex<double>> terms;
  std::vector<ComplexBall> out;
  for (std::size_t j = 0; j < kTerms; ++j) {
    std::complex<double> rest = j < numerator.size() ? middle(numerator[j]) : 0.0;
    for (std::size_t i = 1; i <= j && i < denominator.size(); ++i) {
      rest -= middle(denominator[i]) * terms[j - i];
    }
    terms.push_back(rest / middle(denominator[0]));
    out.push_back({terms[j].real(), terms[j].imag()});
  }
  return out;
}

/// numerator - denominator times quotient.
std::vector<ComplexBall> error_of(const std::vector<ComplexBall>& numerator,
                                  const std::vector<ComplexBall>& denominator,
                                  const std::vector<ComplexBall>& quotient) {
  std::vector<ComplexBall> out = numerator;
  out.resize(std::max(numerator.size(), denominator.size() + quotient.size() - 1));
  for (std::size_t i = 0; i < denominator.size(); ++i) {
    for (std::size_t j = 0; j < quotient.size(); ++j) {
      out[i + j] = out[i + j] - denominator[i] * quotient[j];
    }
  }
  return out;
}

}  // namespace

ControllerPolynomials::ControllerPolynomials(const LiftedSystem& controller)
    : numerators_(static_cast<std::size_t>(controller.b.cols())) {
  const auto n = static_cast<std::size_t>(controller.a.rows());
  const int shift = std::max({integer_shift(controller.a), integer_shift(controller.b), integer_shift(controller.c),
                              integer_shift(controller.d)});
  Integers a = rows_of(controller.a, shift);
  add_to_diagonal(a, -as_integer(1.0, shift));
  const Integers b = rows_of(controller.b.transpose(), shift);
  const std::vector<mpz_class> c = rows_of(controller.c, shift)[0];
  const std::vector<mpz_class> d = rows_of(controller.d, shift)[0];
  // det(s - A) = sum of p_i s^i and its adjugate, sum of M_k s^(n - k), in integers; s = 2^shift (z - 1).
  std::vector<mpz_class> p(n + 1);
  p[n] = 1;
  Integers through(b.size(), std::vector<mpz_class>(n + 1));  // c M b, by input and power
  Integers m(n, std::vector<mpz_class>(n));
  for (std::size_t k = 1; k <= n; ++k) {
    m = columns_of(a, m);
    add_to_diagonal(m, p[n - k + 1]);
    mpz_class trace = 0;
    std::vector<mpz_class> row;  // c M
    for (std::size_t i = 0; i < n; ++i) {
      trace += dot(a[i], m[i]);
      row.push_back(dot(c, m[i]));
    }
    p[n - k] = -trace / mpz_class(static_cast<unsigned long>(k));
    for (std::size_t input = 0; input < b.size(); ++input) {
      through[input][n - k] = dot(row, b[input]);
    }
  }
  for (std::size_t power = 0; power <= n; ++power) {
    const long back = static_cast<long>(shift) * static_cast<long>(n - power);
    denominator_.push_back(to_ball(p[power], back));
    for (std::size_t input = 0; input < b.size(); ++input) {
      const mpz_class sum = d[input] * p[power] + through[input][power];
      numerators_[input].push_back(to_ball(sum, back + shift));
    }
  }
}

ControllerPolynomials::OverArc ControllerPolynomials::over(const Range& angle) const {
  const LoopModel turning = LoopModel::variable(angle.low, angle.high, kAngleVariable);
  const double re = std::cos(turning.constant), im = std::sin(turning.constant);
  const ComplexModel d{cos(turning) - LoopModel(re), sin(turning) - LoopModel(im)};
  const double radius = bound_of_size(d);
  const ComplexBall start{Ball(re) - Ball(1.0), im};
  const std::vector<ComplexBall> below = about(denominator_, start);
  const double least = (1.0 - 1e-14) * std::hypot(below[0].re.constant, below[0].im.constant) -
                       std::hypot(below[0].re.rest, below[0].im.rest) - bound_of(below, radius, 1);
  OverArc out{.valid = least > 0.0, .response = {}, .numerators = {}, .denominator = value_at(below, d)};
  for (const std::vector<Ball>& numerator : numerators_) {
    const std::vector<ComplexBall> above = about(numerator, start);
    out.numerators.push_back(value_at(above, d));
    if (!out.valid) {
      continue;
    }
    const std::vector<ComplexBall> terms = quotient(above, below);
    const double rest = (1.0 + 1e-14) * bound_of(error_of(above, below, terms), radius, 0) / least;
    out.response.push_back(value_at(terms, d));
    out.response.back().re.rest += rest;
    out.response.back().im.rest += rest;
  }
  return out;
}

}  // namespace m100::lab::gains
