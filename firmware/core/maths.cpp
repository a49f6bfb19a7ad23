// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/maths.h"

#include <bit>
#include <cstdint>
#include <limits>

// The polynomials of sine, cosine, arc tangent and exponential are the minimax ones of Sun's fdlibm 5.3, whose error
// bounds are published; the argument reductions are written for our bounded ranges and have no branches.

namespace m100::core {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Nearest integer, halves away from zero; |value| < 2^31 is the caller's responsibility.
std::int32_t nearest(double value) { return static_cast<std::int32_t>(value + (value < 0.0 ? -0.5 : 0.5)); }

/// false for NaN too.
bool within(double value, double bound) { return value >= -bound && value <= bound; }

/// angle = quarter * pi/2 + high + low, |high + low| <= pi/4, low far below the last bit of high.
struct Reduced {
  std::int32_t quarter;
  double high;
  double low;
};

/// Cody and Waite with pi/2 in pieces of 33 bits: quarter has at most 16 bits, so its products with them are exact.
Reduced reduce(double angle_rad) {
  constexpr double kTwoOverPi = 6.36619772367581382433e-01;
  constexpr double kPiece1 = 1.57079632673412561417e+00;
  constexpr double kPiece2 = 6.07710050630396597660e-11;
  constexpr double kRemainder = 2.02226624879595063154e-21;
  const std::int32_t quarter = nearest(angle_rad * kTwoOverPi);
  const auto count = static_cast<double>(quarter);
  const double first = angle_rad - count * kPiece1;
  const double second = count * kPiece2;
  const double rest = first - second;
  const double lost = count * kRemainder - ((first - rest) - second);
  const double high = rest - lost;
  return {.quarter = quarter, .high = high, .low = (rest - high) - lost};
}

/// sin(x + low), |x| <= pi/4.
double sine_kernel(double x, double low) {
  const double z = x * x;
  const double v = z * x;
  const double r =
      8.33333333332248946124e-03 +
      z * (-1.98412698298579493134e-04 +
           z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
  return x - ((z * (0.5 * low - v * r) - low) - v * -1.66666666666666324348e-01);
}

/// cos(x + low), |x| <= pi/4.
double cosine_kernel(double x, double low) {
  const double z = x * x;
  const double r = z * (4.16666666666666019037e-02 +
                        z * (-1.38888888888741095749e-03 +
                             z * (2.48015872894767294178e-05 +
                                  z * (-2.75573143513906633035e-07 +
                                       z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
  const double half = 0.5 * z;
  const double w = 1.0 - half;
  return w + (((1.0 - w) - half) + (z * r - x * low));
}

/// Sine of the reduced angle plus `turn` quarters.
double sine_of(const Reduced& angle, std::int32_t turn) {
  const std::uint32_t quadrant = static_cast<std::uint32_t>(angle.quarter + turn) & 3U;
  const double magnitude =
      (quadrant & 1U) == 0U ? sine_kernel(angle.high, angle.low) : cosine_kernel(angle.high, angle.low);
  return (quadrant & 2U) == 0U ? magnitude : -magnitude;
}

Turn<double> both(double angle_rad) {
  constexpr double kNotReduced_rad = 0.78;  // below pi/4: the reduction would return it as it is, with a rest of zero
  if (within(angle_rad, kNotReduced_rad)) {
    return {.sine = sine_kernel(angle_rad, 0.0), .cosine = cosine_kernel(angle_rad, 0.0)};
  }
  if (!within(angle_rad, kLargestAngle_rad)) {
    return {.sine = kNan, .cosine = kNan};
  }
  const Reduced reduced = reduce(angle_rad);
  const double s = sine_kernel(reduced.high, reduced.low);
  const double c = cosine_kernel(reduced.high, reduced.low);
  const std::uint32_t quadrant = static_cast<std::uint32_t>(reduced.quarter) & 3U;
  const double sine = (quadrant & 1U) == 0U ? s : c;
  const double cosine = (quadrant & 1U) == 0U ? c : s;
  const bool cosine_turns = quadrant == 1U || quadrant == 2U;
  return {.sine = (quadrant & 2U) == 0U ? sine : -sine, .cosine = cosine_turns ? -cosine : cosine};
}

// Not in each of the functions below: they are the same for float and double.
[[gnu::noinline]] double sine(double angle_rad) {
  return within(angle_rad, kLargestAngle_rad) ? sine_of(reduce(angle_rad), 0) : kNan;
}

[[gnu::noinline]] double cosine(double angle_rad) {
  return within(angle_rad, kLargestAngle_rad) ? sine_of(reduce(angle_rad), 1) : kNan;
}

double tangent(double angle_rad) {
  if (!within(angle_rad, kLargestAngle_rad)) {
    return kNan;
  }
  const Turn<double> turn = both(angle_rad);
  return turn.sine / turn.cosine;
}

/// atan(x) - x as a polynomial, |x| <= 7/16.
double arc_tangent_excess(double x) {
  const double z = x * x;
  const double w = z * z;
  const double even = z * (3.33333333333329318027e-01 +
                           w * (1.42857142725034663711e-01 +
                                w * (9.09088713343650656196e-02 +
                                     w * (6.66107313738753120669e-02 +
                                          w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const double odd =
      w *
      (-1.99999999998764832476e-01 +
       w * (-1.11111104054623557880e-01 +
            w * (-7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  return -x * (even + odd);
}

/// An angle as the sum of two doubles.
struct LongAngle {
  double high;
  double low;
};

/// atan(small / large) for 0 <= small <= large, large > 0, by
///   atan(t) = atan(c) + atan((t - c) / (1 + c t)), c one of 0, 1/2, 1, nearest to t.
LongAngle first_octant(double small, double large) {
  double base = 0.0;
  double base_low = 0.0;
  double x = 0.0;
  if (small * 16.0 < 7.0 * large) {
    x = small / large;
  } else if (small * 16.0 < 11.0 * large) {
    base = 4.63647609000806093515e-01;
    base_low = 2.26987774529616870924e-17;
    x = (2.0 * small - large) / (2.0 * large + small);
  } else {
    base = 7.85398163397448278999e-01;
    base_low = 3.06161699786838301793e-17;
    x = (small - large) / (large + small);
  }
  const double rest = (arc_tangent_excess(x) + base_low) + x;
  const double high = base + rest;
  return {.high = high, .low = rest - (high - base)};
}

/// The angle from the x axis, 0 to pi, of a vector whose angle from the nearer axis is `octant`.
/// @param steep nearer to the y axis @param behind x is negative
double in_half_plane(const LongAngle& octant, bool steep, bool behind) {
  constexpr double kHalfPi = 1.57079632679489655800e+00;
  constexpr double kHalfPiLow = 6.12323399573676603587e-17;
  if (steep) {
    const double turned = behind ? -octant.high : octant.high;
    const double turned_low = behind ? -octant.low : octant.low;
    return kHalfPi - ((turned - kHalfPiLow) + turned_low);
  }
  return behind ? kPi - ((octant.high - 2.0 * kHalfPiLow) + octant.low) : octant.high;
}

double arc_tangent(double y, double x) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  if (!within(y, kLargest) || !within(x, kLargest)) {
    return kNan;
  }
  double rise = y < 0.0 ? -y : y;
  double run = x < 0.0 ? -x : x;
  const bool steep = rise > run;
  if (rise == 0.0 && run == 0.0) {
    return 0.0;
  }
  // By a power of two, which is exact: keeps 16 * rise finite, and both away from the coarse subnormals.
  const double larger = steep ? rise : run;
  const double scale = larger > 0x1p+960 ? 0x1p-64 : (larger < 0x1p-960 ? 0x1p+64 : 1.0);
  rise *= scale;
  run *= scale;
  const LongAngle octant = steep ? first_octant(run, rise) : first_octant(rise, run);
  const double angle = in_half_plane(octant, steep, x < 0.0);
  return y < 0.0 ? -angle : angle;
}

double arc_sine(double value) {
  const double v = clamp(value, -1.0, 1.0);
  return arc_tangent(v, core::sqrt((1.0 - v) * (1.0 + v)));
}

/// 2^exponent, -1022 <= exponent <= 1023.
double power_of_two(std::int32_t exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52U);
}

/// e^v = 2^k e^r, r = v - k ln 2 as high - low, e^r by fdlibm's rational form of r coth(r / 2).
double exponential(double value) {
  const double v = clamp(value, -80.0, 80.0);
  if (!within(v, 80.0)) {
    return kNan;
  }
  constexpr double kOneOverLn2 = 1.44269504088896338700e+00;
  constexpr double kLn2High = 6.93147180369123816490e-01;
  constexpr double kLn2Low = 1.90821492927058770002e-10;
  const std::int32_t k = nearest(v * kOneOverLn2);
  const double high = v - static_cast<double>(k) * kLn2High;
  const double low = static_cast<double>(k) * kLn2Low;
  const double r = high - low;
  const double z = r * r;
  const double c =
      r -
      z * (1.66666666666666019037e-01 +
           z * (-2.77777777770155933842e-03 +
                z * (6.61375632143793436117e-05 + z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))));
  return (1.0 - ((low - (r * c) / (2.0 - c)) - high)) * power_of_two(k);
}

/// angle - k 2 pi by the same pieces as reduce(); k has at most 14 bits.
double whole_turns_off(double angle_rad) {
  constexpr double kPerTurn = 1.59154943091895345608e-01;
  constexpr double kPiece1 = 4 * 1.57079632673412561417e+00;
  constexpr double kRemainder = 4 * 6.07710050650619224932e-11;
  const auto turns = static_cast<double>(nearest(angle_rad * kPerTurn));
  return (angle_rad - turns * kPiece1) - turns * kRemainder;
}

}  // namespace

template <typename T>
T sin(T angle_rad) {
  return static_cast<T>(sine(static_cast<double>(angle_rad)));
}
template <typename T>
T cos(T angle_rad) {
  return static_cast<T>(cosine(static_cast<double>(angle_rad)));
}
template <typename T>
Turn<T> turn_of(T angle_rad) {
  const Turn<double> turn = both(static_cast<double>(angle_rad));
  return {.sine = static_cast<T>(turn.sine), .cosine = static_cast<T>(turn.cosine)};
}
template <typename T>
T tan(T angle_rad) {
  return static_cast<T>(tangent(static_cast<double>(angle_rad)));
}
template <typename T>
T atan2(T y, T x) {
  return static_cast<T>(arc_tangent(static_cast<double>(y), static_cast<double>(x)));
}
template <typename T>
T asin(T value) {
  return static_cast<T>(arc_sine(static_cast<double>(value)));
}
template <typename T>
T exp(T value) {
  return static_cast<T>(exponential(static_cast<double>(value)));
}
template <typename T>
T wrap_pi(T angle_rad) {
  constexpr auto kHalfTurn = static_cast<T>(kPi);
  if (angle_rad > -kHalfTurn && angle_rad <= kHalfTurn) {
    return angle_rad;
  }
  if (!within(static_cast<double>(angle_rad), kLargestAngle_rad)) {
    return static_cast<T>(kNan);
  }
  const auto wrapped = static_cast<T>(whole_turns_off(static_cast<double>(angle_rad)));
  if (wrapped <= -kHalfTurn) {
    return kHalfTurn;
  }
  return wrapped < kHalfTurn ? wrapped : kHalfTurn;
}

#define M100_INSTANTIATE(T)       \
  template T sin<T>(T);           \
  template T cos<T>(T);           \
  template T tan<T>(T);           \
  template Turn<T> turn_of<T>(T); \
  template T atan2<T>(T, T);      \
  template T asin<T>(T);          \
  template T exp<T>(T);           \
  template T wrap_pi<T>(T);
M100_INSTANTIATE(float)
M100_INSTANTIATE(double)
#undef M100_INSTANTIATE

}  // namespace m100::core
