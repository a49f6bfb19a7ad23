// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/assert.h"

namespace m100::model {

/// A small square matrix of fixed size, row-major: entry (row, col) is [row * kSize + col].
template <typename Real, std::size_t kSize>
using SquareMatrix = std::array<Real, kSize * kSize>;

template <std::size_t kSize, typename Matrix>
constexpr Matrix matrix_product(const Matrix& left, const Matrix& right) {
  Matrix out{};
  for (std::size_t row = 0; row < kSize; ++row) {
    for (std::size_t inner = 0; inner < kSize; ++inner) {
      for (std::size_t col = 0; col < kSize; ++col) {
        out[row * kSize + col] += left[row * kSize + inner] * right[inner * kSize + col];
      }
    }
  }
  return out;
}

/// Maximum over the rows of the sum of absolute entries.
template <std::size_t kSize, typename Matrix>
constexpr typename Matrix::value_type row_sum_norm(const Matrix& matrix) {
  using Real = typename Matrix::value_type;
  Real most(0);
  for (std::size_t row = 0; row < kSize; ++row) {
    Real sum(0);
    for (std::size_t col = 0; col < kSize; ++col) {
      const Real entry = matrix[row * kSize + col];
      sum += entry < Real(0) ? -entry : entry;
    }
    most = sum > most ? sum : most;
  }
  return most;
}

inline constexpr int kMaxHalvings = 24;
/// Last power of the series: 1 / 24! is 2e-24, below the last bit of every sum, also in a long double of 80 bits
/// (x86-64).
inline constexpr int kExponentialTerms = 24;

/// e^matrix: halves the matrix until its row sums are at most `series_norm`, sums its Taylor series, and squares the
/// result as many times. It uses only + - * /, so in double it gives the same bits on every machine (promise R6).
/// Requires row sums of at most 2^kMaxHalvings times series_norm. Cost: kExponentialTerms products of kSize x kSize and
/// one for each halving; on the target before the first tick only.
template <std::size_t kSize, typename Real>
constexpr SquareMatrix<Real, kSize> exponential(SquareMatrix<Real, kSize> matrix, Real series_norm = Real(1)) {
  M100_ASSERT(series_norm > Real(0) && series_norm <= Real(1));
  int halvings = 0;
  for (Real norm = row_sum_norm<kSize>(matrix); norm > series_norm && halvings < kMaxHalvings; norm /= Real(2)) {
    ++halvings;
    for (Real& entry : matrix) {
      entry /= Real(2);
    }
  }
  M100_ASSERT(row_sum_norm<kSize>(matrix) <= series_norm);  // neither too large nor NaN
  SquareMatrix<Real, kSize> term{};
  for (std::size_t i = 0; i < kSize; ++i) {
    term[i * kSize + i] = Real(1);
  }
  SquareMatrix<Real, kSize> sum = term;
  for (int n = 1; n <= kExponentialTerms; ++n) {
    term = matrix_product<kSize>(term, matrix);
    for (std::size_t i = 0; i < term.size(); ++i) {
      term[i] /= static_cast<Real>(n);
      sum[i] += term[i];
    }
  }
  for (int i = 0; i < halvings; ++i) {
    sum = matrix_product<kSize>(sum, sum);
  }
  return sum;
}

}  // namespace m100::model
