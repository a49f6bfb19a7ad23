// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <compare>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace m100::core {

/// A number in 64 bits: 20 before the binary point (sign included), 44 after it. Range +-524288, step 6e-14: positions,
/// angles and the variances of a filter in SI units fit without scaling. It is used as a float is, also in Eigen's
/// vectors and matrices. Each operation rounds to the nearest step (a quotient towards zero) and ends at the ends of
/// the range. Only integer operations of 64 bits: the same bits on every machine. Cost: about 30 instructions a
/// product.
class Fixed {
 public:
  static constexpr int kFractionBits = 44;

  constexpr Fixed() = default;
  /// The nearest number, or the end of the range. Not for NaN.
  template <typename Real>
  requires std::is_arithmetic_v<Real>
  constexpr explicit Fixed(Real value) {
    constexpr double kEnd = static_cast<double>(kMax);  // 2^63
    const double steps = static_cast<double>(value) * kOne + (value < Real(0) ? -0.5 : 0.5);
    raw_ = steps >= kEnd ? kMax : steps <= -kEnd ? -kMax : static_cast<std::int64_t>(steps);
  }
  template <typename Real>
  requires std::is_floating_point_v<Real>
  constexpr explicit operator Real() const { return static_cast<Real>(raw_) * static_cast<Real>(1.0 / kOne); }
  static constexpr Fixed from_raw(std::int64_t raw) {
    Fixed out;
    out.raw_ = raw;
    return out;
  }
  constexpr std::int64_t raw() const { return raw_; }
  constexpr auto operator<=>(const Fixed&) const = default;

  constexpr Fixed operator-() const { return from_raw(-raw_); }
  friend constexpr Fixed operator+(Fixed a, Fixed b) {
    std::int64_t sum = 0;
    const bool overflows = __builtin_add_overflow(a.raw_, b.raw_, &sum) || sum < -kMax;
    return from_raw(!overflows ? sum : a.raw_ > 0 ? kMax : -kMax);
  }
  friend constexpr Fixed operator-(Fixed a, Fixed b) { return a + -b; }
  friend constexpr Fixed operator*(Fixed a, Fixed b) {
    const std::uint64_t x = a.size(), y = b.size();
    // The product in 128 bits, from halves of 32 bits.
    const std::uint64_t low = half(x) * half(y);
    const std::uint64_t first = (x >> 32U) * half(y) + (low >> 32U);
    const std::uint64_t second = half(x) * (y >> 32U) + half(first);
    std::uint64_t high = (x >> 32U) * (y >> 32U) + (first >> 32U) + (second >> 32U);
    const std::uint64_t bottom = second << 32U | half(low);
    const std::uint64_t rounded = bottom + (std::uint64_t{1} << (kFractionBits - 1));
    high += rounded < bottom ? 1U : 0U;
    const bool fits = high >> (kFractionBits - 1) == 0;
    return of_size(fits ? high << (64 - kFractionBits) | rounded >> kFractionBits : kMax, (a.raw_ < 0) != (b.raw_ < 0));
  }
  /// Long division. By zero: the end of the range.
  friend constexpr Fixed operator/(Fixed a, Fixed b) {
    const std::uint64_t divisor = b.size();
    if (divisor == 0) {
      return of_size(kMax, a.raw_ < 0);
    }
    std::uint64_t quotient = a.size() / divisor, rest = a.size() % divisor;
    for (int bit = 0; bit < kFractionBits && quotient <= kMax; ++bit) {
      rest <<= 1U;
      quotient = quotient << 1U | (rest >= divisor ? 1U : 0U);
      rest -= rest >= divisor ? divisor : 0U;
    }
    return of_size(quotient <= kMax ? quotient : kMax, (a.raw_ < 0) != (b.raw_ < 0));
  }
  constexpr Fixed& operator+=(Fixed other) { return *this = *this + other; }
  constexpr Fixed& operator-=(Fixed other) { return *this = *this - other; }
  constexpr Fixed& operator*=(Fixed other) { return *this = *this * other; }
  constexpr Fixed& operator/=(Fixed other) { return *this = *this / other; }

 private:
  static constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  static constexpr double kOne = static_cast<double>(std::int64_t{1} << kFractionBits);
  static constexpr std::uint64_t half(std::uint64_t bits) { return bits & 0xFFFFFFFFU; }
  constexpr std::uint64_t size() const { return static_cast<std::uint64_t>(raw_ < 0 ? -raw_ : raw_); }
  static constexpr Fixed of_size(std::uint64_t size, bool negative) {
    const auto raw = static_cast<std::int64_t>(size);
    return from_raw(negative ? -raw : raw);
  }

  std::int64_t raw_ = 0;
};

}  // namespace m100::core
