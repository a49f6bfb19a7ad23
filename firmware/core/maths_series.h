// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/maths.h"

// The coefficients of maths.cpp, for each scalar. Those of double are the minimax polynomials of Sun's fdlibm 5.3,
// whose error bounds are published; those of float are our own, with the least maximum relative error (Lawson's
// iteration over 120 Chebyshev points): sine 2^-28, cosine 2^-33, arc tangent 2^-29.6, exponential 2^-30.7, apart
// from the rounding of 2^-24.
namespace m100::core {

template <typename T>
struct Series;

template <>
struct Series<double> {
  /// Largest angle that the functions accept: up to it, the first two pieces times the number of quarters are exact.
  static constexpr double kReach_rad = kLargestAngle_rad;
  // The first two pieces have 31 and 32 bits, the number of quarters at most 16: together no more than a double's 53.
  static constexpr double kPiece1 = 1.57079632673412561417e+00;
  static constexpr double kPiece2 = 6.07710050630396597660e-11;
  static constexpr double kPiece3 = 2.02226624879595063154e-21;
  static constexpr double kTwoOverPi = 6.36619772367581382433e-01;
  static constexpr double kPerTurn = 1.59154943091895345608e-01;
  /// A whole turn in two pieces, for the same range.
  static constexpr double kTurn1 = 4 * kPiece1;
  static constexpr double kTurn2 = 4 * 6.07710050650619224932e-11;

  static constexpr double kSineFirst = -1.66666666666666324348e-01;
  static constexpr std::array<double, 5> kSine{8.33333333332248946124e-03, -1.98412698298579493134e-04,
                                               2.75573137070700676789e-06, -2.50507602534068634195e-08,
                                               1.58969099521155010221e-10};
  static constexpr std::array<double, 6> kCosine{4.16666666666666019037e-02, -1.38888888888741095749e-03,
                                                 2.48015872894767294178e-05, -2.75573143513906633035e-07,
                                                 2.08757232129817482790e-09, -1.13596475577881948265e-11};
  static constexpr std::array<double, 6> kArcEven{3.33333333333329318027e-01, 1.42857142725034663711e-01,
                                                  9.09088713343650656196e-02, 6.66107313738753120669e-02,
                                                  4.97687799461593236017e-02, 1.62858201153657823623e-02};
  static constexpr std::array<double, 5> kArcOdd{-1.99999999998764832476e-01, -1.11111104054623557880e-01,
                                                 -7.69187620504482999495e-02, -5.83357013379057348645e-02,
                                                 -3.65315727442169155270e-02};
  // Angles as a rounded number and its rounding error.
  static constexpr double kArcOfHalf = 4.63647609000806093515e-01;
  static constexpr double kArcOfHalfLow = 2.26987774529616870924e-17;
  static constexpr double kQuarterPi = 7.85398163397448278999e-01;
  static constexpr double kQuarterPiLow = 3.06161699786838301793e-17;
  static constexpr double kHalfPi = 1.57079632679489655800e+00;
  static constexpr double kHalfPiLow = 6.12323399573676603587e-17;
  // ln 2 in two pieces, the first short enough to multiply by the exponent exactly.
  // r coth(r / 2) = 2 + r^2 polynomial(kExponential, r^2).
  static constexpr double kOneOverLn2 = 1.44269504088896338700e+00;
  static constexpr double kLn2High = 6.93147180369123816490e-01;
  static constexpr double kLn2Low = 1.90821492927058770002e-10;
  static constexpr std::array<double, 5> kExponential{1.66666666666666019037e-01, -2.77777777770155933842e-03,
                                                      6.61375632143793436117e-05, -1.65339022054652515390e-06,
                                                      4.13813679705723846039e-08};
  // Vectors larger or smaller than these are scaled before the division.
  static constexpr double kHuge = 0x1p+960;
  static constexpr double kTiny = 0x1p-960;
};

template <>
struct Series<float> {
  // The first two pieces have at most 16 bits, the number of quarters 8. Larger angles are reduced in double.
  static constexpr float kReach_rad = 400.F;
  static constexpr float kPiece1 = 0x1.921ep+0F;
  static constexpr float kPiece2 = 0x1.b544p-16F;
  static constexpr float kPiece3 = 0x1.0b4612p-34F;
  static constexpr float kTwoOverPi = 6.366197467e-01F;
  static constexpr float kPerTurn = 1.591549367e-01F;
  static constexpr float kTurn1 = 4 * kPiece1;
  static constexpr float kTurn2 = 4 * kPiece2;

  static constexpr float kSineFirst = -1.6666654516e-01F;
  static constexpr std::array<float, 2> kSine{8.3321547551e-03F, -1.9514452765e-04F};
  static constexpr std::array<float, 3> kCosine{4.1666645519e-02F, -1.3887308100e-03F, 2.4432207745e-05F};
  static constexpr std::array<float, 3> kArcEven{3.3333303441e-01F, 1.4229581433e-01F, 5.8190976583e-02F};
  static constexpr std::array<float, 2> kArcOdd{-1.9997737961e-01F, -1.0490805082e-01F};
  static constexpr float kArcOfHalf = 4.636476040e-01F;
  static constexpr float kArcOfHalfLow = 5.012158688e-09F;
  static constexpr float kQuarterPi = 7.853981853e-01F;
  static constexpr float kQuarterPiLow = -2.185569414e-08F;
  static constexpr float kHalfPi = 1.570796371e+00F;
  static constexpr float kHalfPiLow = -4.371138829e-08F;
  static constexpr float kOneOverLn2 = 1.442695041e+00F;
  static constexpr float kLn2High = 0x1.62e4p-1F;
  static constexpr float kLn2Low = 1.4286068203e-06F;
  static constexpr std::array<float, 2> kExponential{1.6666615725e-01F, -2.7657508753e-03F};
  static constexpr float kHuge = 0x1p+96F;
  static constexpr float kTiny = 0x1p-96F;
};

/// c[0] + z (c[1] + z (c[2] + ...)).
template <std::size_t kFirst = 0, typename T, std::size_t kCount>
constexpr T polynomial(const std::array<T, kCount>& c, T z) {
  if constexpr (kFirst + 1 == kCount) {
    return c[kFirst];
  } else {
    return c[kFirst] + z * polynomial<kFirst + 1>(c, z);
  }
}

}  // namespace m100::core
