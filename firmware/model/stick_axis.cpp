// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/model/stick_axis.h"

#include <bit>
#include <cstdint>

namespace m100::model {
namespace {

/// Positions of exponent and mantissa in the bits of a number, and the last power of the series below.
template <typename Real>
struct Layout;
template <>
struct Layout<double> {
  using Bits = std::uint64_t;
  static constexpr int kMantissaBits = 52;
  static constexpr int kBias = 1023;
  static constexpr int kLastTerm = 19;
};
template <>
struct Layout<float> {
  using Bits = std::uint32_t;
  static constexpr int kMantissaBits = 23;
  static constexpr int kBias = 127;
  static constexpr int kLastTerm = 9;
};

// ln x = e ln 2 + 2 atanh((m - 1) / (m + 1)), m in (sqrt(1/2), sqrt(2)].
template <typename Real>
Real logarithm(Real x) {
  using Bits = typename Layout<Real>::Bits;
  constexpr int kMantissaBits = Layout<Real>::kMantissaBits;
  const Bits bits = std::bit_cast<Bits>(x);
  constexpr Bits kMantissa = (Bits(1) << kMantissaBits) - 1;
  int exponent = static_cast<int>(bits >> kMantissaBits) - Layout<Real>::kBias;
  Real mantissa = std::bit_cast<Real>((bits & kMantissa) | (Bits(Layout<Real>::kBias) << kMantissaBits));
  if (mantissa > Real(1.4142135623730951)) {
    mantissa *= Real(0.5);
    ++exponent;
  }
  const Real z = (mantissa - Real(1)) / (mantissa + Real(1));
  const Real z2 = z * z;
  Real sum = Real(0);
  for (int k = Layout<Real>::kLastTerm; k >= 1; k -= 2) {
    sum = sum * z2 + Real(1) / static_cast<Real>(k);
  }
  return static_cast<Real>(exponent) * Real(0.69314718055994530942) + Real(2) * z * sum;
}

}  // namespace

template <typename Real>
Real power(Real x, Real exponent) {
  if (!(x > Real(1e-12))) {
    return Real(0);
  }
  return core::exp(exponent * logarithm(x));
}

template float power<float>(float, float);
template double power<double>(double, double);

}  // namespace m100::model
