// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "firmware/core/assert.h"
#include "firmware/core/fixed_point.h"

namespace m100::est {

/// Calls f with std::integral_constant 0 .. kCount-1. It is a loop whose index is a constant expression.
template <int kCount, typename F>
constexpr void unroll([[maybe_unused]] F&& f) {
  [&]<int... kIndex>(std::integer_sequence<int, kIndex...>) { (f(std::integral_constant<int, kIndex>{}), ...); }
  (std::make_integer_sequence<int, kCount>{});
}

/// Repairs that kept a covariance valid. All counters are health outputs.
struct CovarianceHealth {
  std::uint32_t floors = 0;       ///< variances raised to the floor, and decoupled from the other states
  std::uint32_t ceilings = 0;     ///< sigmas halved at the ceiling
  std::uint32_t repairs = 0;      ///< losses of positivity, after which the correlations were reduced
  std::uint32_t saturations = 0;  ///< fixed point only: stores that did not fit
};

/// Covariance of kN states in power-of-two units: entry (i, j) is P_ij / (2^e_i 2^e_j). Choose 2^e_i as the
/// steady-state sigma or a few times that: 32 bits then hold the entries as well as a float does. Transition matrices
/// and measurement rows use the same units: phi_ij 2^(e_j - e_i), h_j 2^(e_j - e_m).
///
/// Only the lower triangle is stored. Every coefficient must be below 8 in size. predict() quarters a variance above
/// kCeiling, which ends the range of fixed point; a variance that is held there no longer fits the others, and the
/// gains computed from it are those of an unstable filter. In float and double it is far beyond every error of a flight
/// (8 km of position at a unit of 8 mm). check() raises a variance below kFloor and repairs lost positivity.
template <typename S, int kN>
class ScaledCovariance {
 public:
  static constexpr auto kSize = static_cast<std::size_t>(kN);
  static constexpr double kFloor = 1.0 / 65536.0;
  static constexpr double kCeiling = std::is_floating_point_v<S> ? 1e12 : 100.0;

  using Matrix = std::array<std::array<S, kSize>, kSize>;
  using Column = std::array<S, kSize>;
  /// P h' and s = h P h' + r of one scalar measurement, r > 0.
  struct Projection {
    Column ph{};
    S s{};
  };

  ScaledCovariance() = default;

  void set_diagonal(const std::array<double, kSize>& variance) {
    p_ = {};
    for (int i = 0; i < kN; ++i) {
      at(i, i) = arithmetic_.template number<double>(variance[index(i)]);
    }
  }

  S operator()(int row, int col) const { return row >= col ? p_[packed(row, col)] : p_[packed(col, row)]; }

  /// Sets the covariances of state i with the other states to zero, and its variance to `variance`.
  void decouple(int i, S variance) {
    M100_ASSERT(i >= 0 && i < kN && variance > S{});
    for (int j = 0; j < kN; ++j) {
      at(i, j) = S{};
    }
    at(i, i) = variance;
  }

  /// P <- phi P phi' + diag(q). Shape::kRows marks for each row which entries of phi are 0, 1 or x (any value); a row
  /// of the identity matrix costs nothing.
  template <typename Shape>
  void predict(const Matrix& phi, const Column& q);

  /// P h' and the variance s of a measurement with row h and variance r > 0. Shape::kRow marks which entries of h are
  /// 0, 1 or x (any value).
  template <typename Shape>
  Projection project(const Column& h, S r);

  /// P <- P - (P h')(P h')' / s. @returns the gain in scaled units.
  Column update(const Projection& projection);

  /// Raises variances to the floor and checks positivity (pivots of L D L'). If positivity is lost, all covariances
  /// between different states shrink by a quarter.
  void check();

  CovarianceHealth health() const {
    CovarianceHealth health = health_;
    health.saturations = arithmetic_.saturations();
    return health;
  }
  core::Arithmetic<S>& arithmetic() { return arithmetic_; }

 private:
  static constexpr std::size_t index(int i) { return static_cast<std::size_t>(i); }
  static constexpr std::size_t packed(int row, int col) { return index(row * (row + 1) / 2 + col); }
  S& at(int row, int col) { return row >= col ? p_[packed(row, col)] : p_[packed(col, row)]; }

  template <typename Shape>
  static constexpr bool is_identity(int row) {
    for (int j = 0; j < kN; ++j) {
      if (Shape::kRows[index(row)][index(j)] != (row == j ? '1' : '0')) {
        return false;
      }
    }
    return true;
  }
  template <typename Shape>
  static constexpr int terms(int row) {
    int count = 0;
    for (const char entry : Shape::kRows[index(row)]) {
      count += entry == '0' ? 0 : 1;
    }
    return count;
  }
  /// The row of a measurement as the only row of a Shape for weighted_sum().
  template <typename Shape>
  struct OnlyRow {
    static constexpr std::array kRows{Shape::kRow};
  };
  /// Sum of weight(k) number(k) over the entries k of row kRow of a Shape that are not 0; an entry 1 has weight 1.
  template <typename Shape, int kRow, typename Number, typename Weight>
  typename core::Arithmetic<S>::Wide weighted_sum(Number&& number, Weight&& weight) {
    typename core::Arithmetic<S>::Wide sum{};
    unroll<kN>([&](auto term) {
      constexpr int k = decltype(term)::value;
      if constexpr (Shape::kRows[index(kRow)][index(k)] == '1') {
        sum += arithmetic_.widen(number(k));
      } else if constexpr (Shape::kRows[index(kRow)][index(k)] == 'x') {
        sum += arithmetic_.product(weight(k), number(k));
      }
    });
    return sum;
  }
  void keep_below_ceiling();
  bool is_positive();

  std::array<S, static_cast<std::size_t>(kN*(kN + 1) / 2)> p_{};
  CovarianceHealth health_;
  core::Arithmetic<S> arithmetic_;
};

template <typename S, int kN>
template <typename Shape>
void ScaledCovariance<S, kN>::predict(const Matrix& phi, const Column& q) {
  Matrix half{};  // phi P
  unroll<kN>([&](auto row) {
    constexpr int i = decltype(row)::value;
    unroll<kN>([&](auto col) {
      constexpr int j = decltype(col)::value;
      if constexpr (is_identity<Shape>(i)) {
        half[i][j] = (*this)(i, j);
      } else {
        half[i][j] = arithmetic_.narrow(
            weighted_sum<Shape, i>([&](int k) { return (*this)(k, j); }, [&](int k) { return phi[i][index(k)]; }));
      }
    });
  });
  unroll<kN>([&](auto row) {
    constexpr int i = decltype(row)::value;
    unroll<i + 1>([&](auto col) {
      constexpr int j = decltype(col)::value;
      constexpr bool kByRow = terms<Shape>(i) <= terms<Shape>(j);  // the sparser of the two rows multiplies
      constexpr int a = kByRow ? i : j;
      constexpr int b = kByRow ? j : i;
      auto sum =
          weighted_sum<Shape, a>([&](int k) { return half[b][index(k)]; }, [&](int k) { return phi[a][index(k)]; });
      if constexpr (i == j) {
        sum += arithmetic_.widen(q[i]);
      }
      p_[packed(i, j)] = arithmetic_.narrow(sum);
    });
  });
  keep_below_ceiling();
}

template <typename S, int kN>
void ScaledCovariance<S, kN>::keep_below_ceiling() {
  const S ceiling = arithmetic_.template number<double>(kCeiling);
  for (int i = 0; i < kN; ++i) {
    if (at(i, i) > ceiling) {  // halve this sigma: D P D with a power of two keeps positivity
      for (int j = 0; j < kN; ++j) {
        at(i, j) = arithmetic_.narrow(arithmetic_.scaled(arithmetic_.widen(at(i, j)), i == j ? -2 : -1));
      }
      ++health_.ceilings;
    }
  }
}

template <typename S, int kN>
template <typename Shape>
typename ScaledCovariance<S, kN>::Projection ScaledCovariance<S, kN>::project(const Column& h, S r) {
  const auto dot = [&](auto&& number) {
    return weighted_sum<OnlyRow<Shape>, 0>(number, [&](int k) { return h[index(k)]; });
  };
  Projection projection;
  unroll<kN>([&](auto row) {
    constexpr int i = decltype(row)::value;
    projection.ph[i] = arithmetic_.narrow(dot([&](int k) { return (*this)(i, k); }));
  });
  projection.s = arithmetic_.narrow(dot([&](int k) { return projection.ph[index(k)]; }) + arithmetic_.widen(r));
  return projection;
}

template <typename S, int kN>
typename ScaledCovariance<S, kN>::Column ScaledCovariance<S, kN>::update(const Projection& projection) {
  Column gain{};
  unroll<kN>([&](auto row) {
    constexpr int i = decltype(row)::value;
    gain[i] = arithmetic_.quotient(projection.ph[i], projection.s);
    unroll<i + 1>([&](auto col) {
      constexpr int j = decltype(col)::value;
      S& entry = p_[packed(i, j)];
      entry = arithmetic_.narrow(arithmetic_.widen(entry) - arithmetic_.product(gain[i], projection.ph[j]));
    });
  });
  return gain;
}

template <typename S, int kN>
void ScaledCovariance<S, kN>::check() {
  const S floor = arithmetic_.template number<double>(kFloor);
  for (int i = 0; i < kN; ++i) {
    if (!(at(i, i) >= floor)) {
      decouple(i, floor);
      ++health_.floors;
    }
  }
  if (!is_positive()) {
    ++health_.repairs;
    for (int i = 0; i < kN; ++i) {
      for (int j = 0; j < i; ++j) {
        const auto wide = arithmetic_.widen(at(i, j));
        at(i, j) = arithmetic_.narrow(wide - arithmetic_.scaled(wide, -2));
      }
    }
  }
}

template <typename S, int kN>
bool ScaledCovariance<S, kN>::is_positive() {
  using Wide = typename core::Arithmetic<S>::Wide;
  std::array<S, static_cast<std::size_t>(kN * (kN + 1) / 2)> c{};  // L D; its diagonal is D
  Matrix l{};
  bool positive = true;
  unroll<kN>([&](auto row) {
    constexpr int i = decltype(row)::value;
    unroll<i + 1>([&](auto col) {
      constexpr int j = decltype(col)::value;
      Wide sum = arithmetic_.widen(p_[packed(i, j)]);
      unroll<j>([&](auto term) {
        constexpr int k = decltype(term)::value;
        sum -= arithmetic_.product(c[packed(i, k)], l[j][k]);
      });
      c[packed(i, j)] = arithmetic_.narrow(sum);
      if constexpr (i != j) {
        l[i][j] = arithmetic_.quotient(c[packed(i, j)], c[packed(j, j)]);
      }
    });
    // After a bad pivot the following entries are meaningless but bounded.
    if (!(c[packed(i, i)] > S{})) {
      positive = false;
      c[packed(i, i)] = arithmetic_.template number<double>(1.0);
    }
  });
  return positive;
}

}  // namespace m100::est
