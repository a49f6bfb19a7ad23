// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/model/stick_axis.h"

#include <bit>
#include <cstdint>

namespace m100::model {
namespace {

// ln x = e ln 2 + 2 atanh((m - 1) / (m + 1)), m in [sqrt(1/2), sqrt(2)).
double logarithm(double x) {
  std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  int exponent = static_cast<int>(bits >> 52U) - 1023;
  bits = (bits & 0x000FFFFFFFFFFFFFULL) | 0x3FF0000000000000ULL;
  double mantissa = std::bit_cast<double>(bits);
  if (mantissa > 1.4142135623730951) {
    mantissa *= 0.5;
    ++exponent;
  }
  const double z = (mantissa - 1.0) / (mantissa + 1.0);
  const double z2 = z * z;
  double sum = 0.0;
  for (int k = 19; k >= 1; k -= 2) {
    sum = sum * z2 + 1.0 / k;
  }
  return exponent * 0.69314718055994530942 + 2.0 * z * sum;
}

}  // namespace

template <typename Real>
Real power(Real x, Real exponent) {
  if (!(x > Real(1e-12))) {
    return Real(0);
  }
  return static_cast<Real>(core::exp(static_cast<double>(exponent) * logarithm(static_cast<double>(x))));
}

template float power<float>(float, float);
template double power<double>(double, double);

}  // namespace m100::model
