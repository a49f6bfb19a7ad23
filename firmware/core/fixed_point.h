// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <compare>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace m100::core {

/// A number in 32 bits: 8 before the binary point (sign included), 24 after it. Range [-128, 128), step 6e-8.
/// It only holds the bits; Arithmetic<Fixed> computes sums and products and counts saturations.
class Fixed {
 public:
  static constexpr int kFractionBits = 24;

  constexpr Fixed() = default;
  static constexpr Fixed from_raw(std::int32_t raw) { return Fixed(raw); }
  constexpr std::int32_t raw() const { return raw_; }
  constexpr auto operator<=>(const Fixed&) const = default;

 private:
  constexpr explicit Fixed(std::int32_t raw) : raw_(raw) {}
  std::int32_t raw_ = 0;
};

/// The operations a filter needs, the same names for every scalar, so that one source serves all of them.
///
/// A sum of products is collected in a Wide and rounded once, by narrow(). Powers of two are exact: scaled(wide, e) is
/// wide * 2^e. This is the version for float and double, where Wide is the number itself and nothing saturates.
template <typename S>
class Arithmetic {
  static_assert(std::is_floating_point_v<S>);

 public:
  using Wide = S;

  template <typename Real>
  static constexpr S number(Real value) {
    return static_cast<S>(value);
  }
  template <typename Real>
  static constexpr Real real(S value) {
    return static_cast<Real>(value);
  }
  static constexpr Wide widen(S a) { return a; }
  static constexpr Wide product(S a, S b) { return a * b; }
  static constexpr Wide scaled(Wide wide, int exponent) { return wide * power_of_two(exponent); }
  constexpr S narrow(Wide wide) { return wide; }
  /// numerator / denominator; the denominator must be positive.
  constexpr S quotient(S numerator, S denominator) { return numerator / denominator; }
  constexpr std::uint32_t saturations() const { return 0; }

 private:
  static constexpr S power_of_two(int exponent) {
    // |exponent| <= 60 by contract.
    using Bits = std::conditional_t<sizeof(S) == sizeof(std::uint64_t), std::uint64_t, std::uint32_t>;
    constexpr int kMantissaBits = std::numeric_limits<S>::digits - 1;
    constexpr int kBias = std::numeric_limits<S>::max_exponent - 1;
    return std::bit_cast<S>(static_cast<Bits>(static_cast<Bits>(kBias + exponent) << kMantissaBits));
  }
};

/// The version for Fixed: products and sums in 64 bits (Q16.48), rounding to nearest (quotients: towards zero),
/// saturating stores. Requires that a sum of products stays below 2^63, i.e. below 32768 in value; up to eight products
/// of a Fixed with a coefficient below 8 meet this.
template <>
class Arithmetic<Fixed> {
 public:
  using Wide = std::int64_t;

  /// The nearest Fixed; a value beyond +-127.99999 gives that limit. Not for NaN.
  template <typename Real>
  static constexpr Fixed number(Real value) {
    constexpr Real kOne = static_cast<Real>(std::int64_t{1} << Fixed::kFractionBits);
    constexpr Real kLimit = Real(127.99999);
    const Real inside = value > kLimit ? kLimit : (value < -kLimit ? -kLimit : value);
    const Real steps = inside * kOne;
    return Fixed::from_raw(static_cast<std::int32_t>(steps + (steps < Real(0) ? Real(-0.5) : Real(0.5))));
  }
  template <typename Real>
  static constexpr Real real(Fixed value) {
    constexpr Real kStep = Real(1) / static_cast<Real>(std::int64_t{1} << Fixed::kFractionBits);
    return static_cast<Real>(value.raw()) * kStep;
  }
  static constexpr Wide widen(Fixed a) { return static_cast<Wide>(a.raw()) * (Wide{1} << Fixed::kFractionBits); }
  static constexpr Wide product(Fixed a, Fixed b) { return static_cast<Wide>(a.raw()) * b.raw(); }
  /// A right shift rounds to nearest; the caller keeps a left shift inside 63 bits.
  static constexpr Wide scaled(Wide wide, int exponent) {
    if (exponent >= 0) {
      return wide * (Wide{1} << exponent);
    }
    return (wide + (Wide{1} << (-exponent - 1))) >> -exponent;
  }
  constexpr Fixed narrow(Wide wide) { return store((wide + kHalf) >> Fixed::kFractionBits); }
  constexpr Fixed quotient(Fixed numerator, Fixed denominator) {
    return store(widen(numerator) / (denominator.raw() > 0 ? denominator.raw() : 1));
  }
  /// Stores that did not fit since construction: a health output, not an error. The count stops at its largest value.
  constexpr std::uint32_t saturations() const { return saturations_; }

 private:
  static constexpr Wide kHalf = Wide{1} << (Fixed::kFractionBits - 1);
  static constexpr Wide kMax = std::numeric_limits<std::int32_t>::max();

  constexpr Fixed store(Wide steps) {
    if (steps > kMax || steps < -kMax) [[unlikely]] {
      saturations_ += saturations_ < std::numeric_limits<std::uint32_t>::max() ? 1U : 0U;
      return Fixed::from_raw(static_cast<std::int32_t>(steps > 0 ? kMax : -kMax));
    }
    return Fixed::from_raw(static_cast<std::int32_t>(steps));
  }

  std::uint32_t saturations_ = 0;
};

}  // namespace m100::core
