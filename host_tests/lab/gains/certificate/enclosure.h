// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "host_tests/lab/gains/complex_number.h"

namespace m100::lab::gains {

/// An interval that contains the exact result: every operation is rounded outwards by one unit in the last place, which
/// is at least twice the rounding error of + - * / and sqrt (IEEE 754, round to nearest). exp, sin and cos of the C
/// library are taken to be within 4 units.
struct Enclosure {
  double low = 0.0;
  double high = 0.0;

  constexpr Enclosure() = default;
  constexpr Enclosure(double exact)
      : low(exact), high(exact) {}  // NOLINT(google-explicit-constructor): a number is one
  constexpr Enclosure(double from, double to) : low(from), high(to) {}

  double middle() const { return 0.5 * (low + high); }
  double magnitude() const { return std::max(std::abs(low), std::abs(high)); }
  bool contains(double value) const { return low <= value && value <= high; }

  static Enclosure outward(double low, double high, double units = 1.0) {
    constexpr double kUnit = std::numeric_limits<double>::epsilon();
    constexpr double kTiny = 1e-300;
    return {low - (units * kUnit * std::abs(low) + kTiny), high + (units * kUnit * std::abs(high) + kTiny)};
  }
  friend Enclosure operator+(const Enclosure& a, const Enclosure& b) { return outward(a.low + b.low, a.high + b.high); }
  friend Enclosure operator-(const Enclosure& a, const Enclosure& b) { return outward(a.low - b.high, a.high - b.low); }
  friend Enclosure operator*(const Enclosure& a, const Enclosure& b) {
    const std::array<double, 4> all{a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high};
    const auto [least, most] = std::minmax_element(all.begin(), all.end());
    return outward(*least, *most);
  }
  friend Enclosure operator/(const Enclosure& a, const Enclosure& b) {
    if (b.contains(0.0)) {
      constexpr double kAnything = std::numeric_limits<double>::infinity();
      return {-kAnything, kAnything};
    }
    const std::array<double, 4> all{a.low / b.low, a.low / b.high, a.high / b.low, a.high / b.high};
    const auto [least, most] = std::minmax_element(all.begin(), all.end());
    return outward(*least, *most);
  }
};

inline Enclosure square(const Enclosure& a) {
  const double most = a.magnitude();
  const double least = a.contains(0.0) ? 0.0 : std::min(std::abs(a.low), std::abs(a.high));
  const Enclosure out = Enclosure::outward(least * least, most * most);
  return {std::max(out.low, 0.0), out.high};
}
inline Enclosure sqrt(const Enclosure& a) {
  const Enclosure out = Enclosure::outward(std::sqrt(std::max(a.low, 0.0)), std::sqrt(std::max(a.high, 0.0)));
  return {std::max(out.low, 0.0), out.high};
}
inline Enclosure exp(const Enclosure& a) { return Enclosure::outward(std::exp(a.low), std::exp(a.high), 4.0); }

/// @pre for more than [-1, 1]: the angle lies in [-1.5, 3.3], where the only extremes are at 0, pi/2 and pi.
inline Enclosure angle_function(const Enclosure& a, double (*function)(double), double greatest_at, double least_at) {
  if (!(a.low >= -1.5 && a.high <= 3.3)) {
    return {-1.0, 1.0};
  }
  constexpr double kNear = 1e-12;
  const auto [least, most] = std::minmax({function(a.low), function(a.high)});  // by value
  Enclosure out = Enclosure::outward(least, most, 4.0);
  const auto reaches = [&](double at) { return a.low <= at + kNear && at - kNear <= a.high; };
  return {reaches(least_at) ? -1.0 : out.low, reaches(greatest_at) ? 1.0 : out.high};
}
inline Enclosure sin(const Enclosure& a) {
  return angle_function(
      a, [](double x) { return std::sin(x); }, 1.5707963267948966, 1e3);
}
inline Enclosure cos(const Enclosure& a) {
  return angle_function(
      a, [](double x) { return std::cos(x); }, 0.0, 3.141592653589793);
}

/// A function of kCount variables over a cell: its values, its value in the middle, and its derivatives over the cell
/// by each variable in half widths of the cell. Every value is cut to what the mean value theorem allows, so that the
/// excess of a long expression is of second order.
template <std::size_t kCount>
struct EnclosedJet {
  Enclosure value;
  Enclosure middle;
  std::array<Enclosure, kCount> by{};

  constexpr EnclosedJet() = default;
  constexpr EnclosedJet(double exact) : value(exact), middle(exact) {}  // NOLINT(google-explicit-constructor): a number
  constexpr EnclosedJet(const Enclosure& of)
      : value(of), middle(of) {}  // NOLINT(google-explicit-constructor): a constant
  EnclosedJet(const Enclosure& over, const Enclosure& in_the_middle, const std::array<Enclosure, kCount>& slopes)
      : value(over), middle(in_the_middle), by(slopes) {
    Enclosure reach = middle;
    for (const Enclosure& slope : by) {
      reach = reach + Enclosure(-slope.magnitude(), slope.magnitude());
    }
    value.low = reach.low > value.low ? reach.low : value.low;
    value.high = reach.high < value.high ? reach.high : value.high;
  }

  static EnclosedJet variable(const Enclosure& of, std::size_t which) {
    const double half = std::max(of.high - of.middle(), of.middle() - of.low);
    EnclosedJet out(of);
    out.middle = Enclosure(of.middle());
    out.by[which] = half > 0.0 ? Enclosure::outward(half, half) : Enclosure(0.0);
    return out;
  }
  /// f(value) with f(middle) and the derivative f'.
  EnclosedJet chain(const Enclosure& over, const Enclosure& in_the_middle, const Enclosure& slope) const {
    std::array<Enclosure, kCount> slopes;
    for (std::size_t k = 0; k < kCount; ++k) {
      slopes[k] = slope * by[k];
    }
    return {over, in_the_middle, slopes};
  }
  friend EnclosedJet operator+(const EnclosedJet& a, const EnclosedJet& b) {
    std::array<Enclosure, kCount> slopes;
    for (std::size_t k = 0; k < kCount; ++k) {
      slopes[k] = a.by[k] + b.by[k];
    }
    return {a.value + b.value, a.middle + b.middle, slopes};
  }
  friend EnclosedJet operator-(const EnclosedJet& a, const EnclosedJet& b) {
    std::array<Enclosure, kCount> slopes;
    for (std::size_t k = 0; k < kCount; ++k) {
      slopes[k] = a.by[k] - b.by[k];
    }
    return {a.value - b.value, a.middle - b.middle, slopes};
  }
  friend EnclosedJet operator*(const EnclosedJet& a, const EnclosedJet& b) {
    std::array<Enclosure, kCount> slopes;
    for (std::size_t k = 0; k < kCount; ++k) {
      slopes[k] = a.by[k] * b.value + a.value * b.by[k];
    }
    return {a.value * b.value, a.middle * b.middle, slopes};
  }
  friend EnclosedJet operator/(const EnclosedJet& a, const EnclosedJet& b) {
    std::array<Enclosure, kCount> slopes;
    const Enclosure value = a.value / b.value;
    for (std::size_t k = 0; k < kCount; ++k) {
      slopes[k] = (a.by[k] - value * b.by[k]) / b.value;
    }
    return {value, a.middle / b.middle, slopes};
  }
};

template <std::size_t kCount>
EnclosedJet<kCount> square(const EnclosedJet<kCount>& a) {
  return a.chain(square(a.value), square(a.middle), Enclosure(2.0) * a.value);
}
template <std::size_t kCount>
EnclosedJet<kCount> sqrt(const EnclosedJet<kCount>& a) {
  const Enclosure root = sqrt(a.value);
  return a.chain(root, sqrt(a.middle), Enclosure(0.5) / root);
}
template <std::size_t kCount>
EnclosedJet<kCount> exp(const EnclosedJet<kCount>& a) {
  const Enclosure value = exp(a.value);
  return a.chain(value, exp(a.middle), value);
}
template <std::size_t kCount>
EnclosedJet<kCount> sin(const EnclosedJet<kCount>& a) {
  return a.chain(sin(a.value), sin(a.middle), cos(a.value));
}
template <std::size_t kCount>
EnclosedJet<kCount> cos(const EnclosedJet<kCount>& a) {
  return a.chain(cos(a.value), cos(a.middle), Enclosure(0.0) - sin(a.value));
}

}  // namespace m100::lab::gains
