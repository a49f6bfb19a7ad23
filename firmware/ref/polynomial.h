// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/ref/window.h"

namespace m100::ref {

inline constexpr std::size_t kCoefficients = 8;  ///< degree 7: minimum snap

/// A polynomial in normalised time s = t / duration, 0 <= s <= 1, lowest power first.
template <typename T>
struct Polynomial {
  std::array<T, kCoefficients> c{};

  /// Value and its first two time derivatives. Horner, three products for each coefficient after the first. The
  /// coefficients from c[count] on must be zero; count is at least 1.
  AxisReference<T> at(T s, T duration_s, std::size_t count = kCoefficients) const {
    T value = c[count - 1], slope = T(0), bend = T(0);
    for (std::size_t i = count - 1; i-- > 0;) {
      bend = bend * s + slope;
      slope = slope * s + value;
      value = value * s + c[i];
    }
    return {.position_m = value,
            .velocity_m_s = slope / duration_s,
            .acceleration_m_s2 = T(2) * bend / (duration_s * duration_s)};
  }
  /// The time derivative of any order; slower than at().
  double derivative(unsigned order, double s, double duration_s) const {
    double sum = 0.0, power = 1.0, scale = 1.0;
    for (std::size_t i = order; i < kCoefficients; ++i) {
      double factor = 1.0;
      for (std::size_t k = 0; k < order; ++k) {
        factor *= static_cast<double>(i - k);
      }
      sum += factor * static_cast<double>(c[i]) * power;
      power *= s;
    }
    for (unsigned k = 0; k < order; ++k) {
      scale *= duration_s;
    }
    return sum / scale;
  }
  /// Number of coefficients up to the last nonzero one; at least one.
  std::size_t count() const {
    std::size_t count = kCoefficients;
    while (count > 1 && c[count - 1] == T(0)) {
      --count;
    }
    return count;
  }
};

/// Position and its first three derivatives by normalised time, at both ends of a piece.
struct EndStates {
  std::array<double, 4> start{};
  std::array<double, 4> end{};
};

/// The polynomial of degree 7 through both ends.
Polynomial<double> through(const EndStates& ends);

/// The polynomial of degree 5 from rest at `from` to rest at `to`: from + (to - from) (10 s^3 - 15 s^4 + 6 s^5).
/// Largest velocity 1.875 (to - from) / T, largest acceleration 5.7735 (to - from) / T^2, T the duration.
Polynomial<double> quintic(double from, double to);

}  // namespace m100::ref
