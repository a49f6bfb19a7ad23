// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/maths.h"

#include <bit>
#include <cstdint>
#include <limits>

#include "firmware/core/maths_series.h"

// One program for float and double, each in its own arithmetic; the argument reductions are written for our bounded
// ranges.

namespace m100::core {
namespace {

template <typename T>
constexpr T kNan = std::numeric_limits<T>::quiet_NaN();

/// Nearest integer, halves away from zero; |value| < 2^31 - 1 is the caller's responsibility.
template <typename T>
std::int32_t nearest(T value) {
  return static_cast<std::int32_t>(value + (value < T(0) ? T(-0.5) : T(0.5)));
}

/// false for NaN too.
template <typename T>
bool within(T value, T bound) {
  return value >= -bound && value <= bound;
}

/// Whether an angle can be reduced in its own scalar, as all angles of a flight can. Larger ones are reduced in double,
/// which some processors emulate in software.
template <typename T>
bool in_reach(T angle_rad) {
  return sizeof(T) == sizeof(double) || within(angle_rad, Series<T>::kReach_rad);
}

/// angle = quarter * pi/2 + high + low, |high + low| <= pi/4, low below the last bit of high.
template <typename T>
struct Reduced {
  std::int32_t quarter;
  T high;
  T low;
};

/// Cody and Waite: the products of `quarter` with the first two pieces are exact. |angle| <= kReach_rad.
template <typename T>
Reduced<T> reduce(T angle_rad) {
  using Numbers = Series<T>;
  const std::int32_t quarter = nearest(angle_rad * Numbers::kTwoOverPi);
  const auto count = static_cast<T>(quarter);
  const T first = angle_rad - count * Numbers::kPiece1;
  const T second = count * Numbers::kPiece2;
  const T rest = first - second;
  const T lost = count * Numbers::kPiece3 - ((first - rest) - second);
  const T high = rest - lost;
  return {.quarter = quarter, .high = high, .low = (rest - high) - lost};
}

/// sin(x + low), |x| <= pi/4.
template <typename T>
T sine_kernel(T x, T low) {
  const T z = x * x;
  const T v = z * x;
  const T r = polynomial(Series<T>::kSine, z);
  return x - ((z * (T(0.5) * low - v * r) - low) - v * Series<T>::kSineFirst);
}

/// cos(x + low), |x| <= pi/4.
template <typename T>
T cosine_kernel(T x, T low) {
  const T z = x * x;
  const T r = z * polynomial(Series<T>::kCosine, z);
  const T half = T(0.5) * z;
  const T w = T(1) - half;
  return w + (((T(1) - w) - half) + (z * r - x * low));
}

/// Sine of the reduced angle plus `turn` quarters.
template <typename T>
T sine_of(const Reduced<T>& angle, std::int32_t turn) {
  const std::uint32_t quadrant = static_cast<std::uint32_t>(angle.quarter + turn) & 3U;
  const T magnitude = (quadrant & 1U) == 0U ? sine_kernel(angle.high, angle.low) : cosine_kernel(angle.high, angle.low);
  return (quadrant & 2U) == 0U ? magnitude : -magnitude;
}

template <typename T>
SinCos<T> both(T angle_rad) {
  constexpr T kNotReduced_rad = T(0.78);  // below pi/4: the reduction would return the angle itself and zero
  if (within(angle_rad, kNotReduced_rad)) {
    return {.sine = sine_kernel(angle_rad, T(0)), .cosine = cosine_kernel(angle_rad, T(0))};
  }
  if (!within(angle_rad, static_cast<T>(kLargestAngle_rad))) {
    return {.sine = kNan<T>, .cosine = kNan<T>};
  }
  const Reduced<T> reduced = reduce(angle_rad);
  const T s = sine_kernel(reduced.high, reduced.low);
  const T c = cosine_kernel(reduced.high, reduced.low);
  const std::uint32_t quadrant = static_cast<std::uint32_t>(reduced.quarter) & 3U;
  const T sine = (quadrant & 1U) == 0U ? s : c;
  const T cosine = (quadrant & 1U) == 0U ? c : s;
  const bool cosine_turns = quadrant == 1U || quadrant == 2U;
  return {.sine = (quadrant & 2U) == 0U ? sine : -sine, .cosine = cosine_turns ? -cosine : cosine};
}

/// The sine of the angle plus `turn` quarters.
template <typename T>
[[gnu::noinline]] T sine_after(T angle_rad, std::int32_t turn) {
  return within(angle_rad, static_cast<T>(kLargestAngle_rad)) ? sine_of(reduce(angle_rad), turn) : kNan<T>;
}

/// As sine_after(), but reduced in double and rounded once.
template <typename T>
[[gnu::noinline]] T far_sine_after(T angle_rad, std::int32_t turn) {
  return static_cast<T>(sine_after(static_cast<double>(angle_rad), turn));
}

/// atan(x) - x as a polynomial, |x| <= 7/16.
template <typename T>
T arc_tangent_excess(T x) {
  const T z = x * x;
  const T w = z * z;
  const T even = z * polynomial(Series<T>::kArcEven, w);
  const T odd = w * polynomial(Series<T>::kArcOdd, w);
  return -x * (even + odd);
}

/// An angle as the sum of two numbers.
template <typename T>
struct LongAngle {
  T high;
  T low;
};

/// atan(small / large) for 0 <= small <= large, large > 0, by
///   atan(t) = atan(c) + atan((t - c) / (1 + c t)), c = 0 below t = 7/16, 1/2 below 11/16, otherwise 1.
template <typename T>
LongAngle<T> first_octant(T small, T large) {
  T base = T(0);
  T base_low = T(0);
  T x = T(0);
  if (small * T(16) < T(7) * large) {
    x = small / large;
  } else if (small * T(16) < T(11) * large) {
    base = Series<T>::kArcOfHalf;
    base_low = Series<T>::kArcOfHalfLow;
    x = (T(2) * small - large) / (T(2) * large + small);
  } else {
    base = Series<T>::kQuarterPi;
    base_low = Series<T>::kQuarterPiLow;
    x = (small - large) / (large + small);
  }
  const T rest = (arc_tangent_excess(x) + base_low) + x;
  const T high = base + rest;
  return {.high = high, .low = rest - (high - base)};
}

/// The angle from the x axis, 0 to pi, of a vector whose angle from the nearer axis is `octant`.
/// @param steep nearer to the y axis @param behind x is negative
template <typename T>
T in_half_plane(const LongAngle<T>& octant, bool steep, bool behind) {
  constexpr T kHalfPi = Series<T>::kHalfPi;
  constexpr T kHalfPiLow = Series<T>::kHalfPiLow;
  if (steep) {
    const T turned = behind ? -octant.high : octant.high;
    const T turned_low = behind ? -octant.low : octant.low;
    return kHalfPi - ((turned - kHalfPiLow) + turned_low);
  }
  return behind ? T(2) * kHalfPi - ((octant.high - T(2) * kHalfPiLow) + octant.low) : octant.high;
}

template <typename T>
T arc_tangent(T y, T x) {
  constexpr T kLargest = std::numeric_limits<T>::max();
  if (!within(y, kLargest) || !within(x, kLargest)) {
    return kNan<T>;
  }
  T rise = y < T(0) ? -y : y;
  T run = x < T(0) ? -x : x;
  const bool steep = rise > run;
  if (rise == T(0) && run == T(0)) {
    return T(0);
  }
  // Scaling by a power of two is exact: it keeps 16 * rise finite, and both numbers away from the coarse subnormals.
  const T larger = steep ? rise : run;
  const T scale = larger > Series<T>::kHuge ? T(0x1p-64) : (larger < Series<T>::kTiny ? T(0x1p+64) : T(1));
  rise *= scale;
  run *= scale;
  const LongAngle<T> octant = steep ? first_octant(run, rise) : first_octant(rise, run);
  const T angle = in_half_plane(octant, steep, x < T(0));
  return y < T(0) ? -angle : angle;
}

/// 2^exponent, which must be a normal number.
double power_of_two(std::int32_t exponent, double) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52U);
}
float power_of_two(std::int32_t exponent, float) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(exponent + 127) << 23U);
}

/// e^v = 2^k e^r, r = v - k ln 2 as high - low, e^r by fdlibm's rational form of r coth(r / 2).
template <typename T>
T exponential(T value) {
  const T v = clamp(value, T(-80), T(80));
  if (!within(v, T(80))) {
    return kNan<T>;
  }
  const std::int32_t k = nearest(v * Series<T>::kOneOverLn2);
  const T high = v - static_cast<T>(k) * Series<T>::kLn2High;
  const T low = static_cast<T>(k) * Series<T>::kLn2Low;
  const T r = high - low;
  const T z = r * r;
  const T c = r - z * polynomial(Series<T>::kExponential, z);
  return (T(1) - ((low - (r * c) / (T(2) - c)) - high)) * power_of_two(k, T(0));
}

/// angle - k 2 pi, nearest to zero; 2 pi is the sum of kTurn1 and kTurn2. |angle| <= kReach_rad.
template <typename T>
T whole_turns_off(T angle_rad) {
  const auto turns = static_cast<T>(nearest(angle_rad * Series<T>::kPerTurn));
  return (angle_rad - turns * Series<T>::kTurn1) - turns * Series<T>::kTurn2;
}

}  // namespace

template <typename T>
T sin(T angle_rad) {
  return in_reach(angle_rad) ? sine_after(angle_rad, 0) : far_sine_after(angle_rad, 0);
}
template <typename T>
T cos(T angle_rad) {
  return in_reach(angle_rad) ? sine_after(angle_rad, 1) : far_sine_after(angle_rad, 1);
}
template <typename T>
SinCos<T> sin_cos_of(T angle_rad) {
  if (!in_reach(angle_rad)) {
    return {.sine = far_sine_after(angle_rad, 0), .cosine = far_sine_after(angle_rad, 1)};
  }
  return both(angle_rad);
}
template <typename T>
T tan(T angle_rad) {
  if (!within(angle_rad, static_cast<T>(kLargestAngle_rad))) {
    return kNan<T>;
  }
  const SinCos<T> turn = sin_cos_of(angle_rad);
  return turn.sine / turn.cosine;
}
template <typename T>
T atan2(T y, T x) {
  return arc_tangent(y, x);
}
template <typename T>
T asin(T value) {
  const T v = clamp(value, T(-1), T(1));
  return arc_tangent(v, core::sqrt((T(1) - v) * (T(1) + v)));
}
template <typename T>
T exp(T value) {
  return exponential(value);
}
template <typename T>
T wrap_pi(T angle_rad) {
  constexpr auto kHalfTurn = static_cast<T>(kPi);
  if (angle_rad > -kHalfTurn && angle_rad <= kHalfTurn) {
    return angle_rad;
  }
  if (!within(angle_rad, static_cast<T>(kLargestAngle_rad))) {
    return kNan<T>;
  }
  const T wrapped = in_reach(angle_rad) ? whole_turns_off(angle_rad)
                                        : static_cast<T>(whole_turns_off(static_cast<double>(angle_rad)));
  if (wrapped <= -kHalfTurn) {
    return kHalfTurn;
  }
  return wrapped < kHalfTurn ? wrapped : kHalfTurn;
}

#define M100_INSTANTIATE(T)            \
  template T sin<T>(T);                \
  template T cos<T>(T);                \
  template T tan<T>(T);                \
  template SinCos<T> sin_cos_of<T>(T); \
  template T atan2<T>(T, T);           \
  template T asin<T>(T);               \
  template T exp<T>(T);                \
  template T wrap_pi<T>(T);
M100_INSTANTIATE(float)
M100_INSTANTIATE(double)
#undef M100_INSTANTIATE

}  // namespace m100::core
