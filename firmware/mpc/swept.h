// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/columns.h"
#include "firmware/mpc/horizontal_mpc.h"

// The four operations of the active-set iteration on the swept tableau, a symmetric 20 x 20 matrix of which the lower
// triangle is kept (gain_table.h): gather() reads a column, clear_below() sets a column to zero below the diagonal,
// add_product() multiplies by a vector, add_outer_product() adds the product of two vectors. The loops stay loops,
// because unrolling them all would cost seventy kilobytes of flash; they process four numbers at a time if that saves
// loads.
namespace m100::mpc {

/// The tableau of the empty active set: H^-1, every input free.
template <typename T>
inline void start_over(const GainTable<T>& table, Tableau<T>& tableau) {
  tableau.swept = table.inverse_hessian;
  tableau.side = {};
}

/// The tableau of the full active set: -H. Leaves the sides to the caller.
template <typename T>
inline void start_full(const GainTable<T>& table, Tableau<T>& tableau) {
  for (std::size_t i = 0; i < kHorizon; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      tableau.swept[packed_row(i) + j] = -table.hessian[i * kHorizon + j];
    }
  }
}

/// pivot = column k: row k up to the diagonal, then down the rows.
template <typename T>
[[gnu::always_inline]] inline void gather(const T* swept, std::size_t k, T* pivot) {
  const T* row = swept + packed_row(k);
  for (std::size_t i = 0; i <= k; ++i) {
    pivot[i] = row[i];
  }
  const T* at = row + k;
  for (std::size_t i = k + 1; i < kHorizon; ++i) {
    at += padded_row(i - 1);
    pivot[i] = *at;
  }
}

/// Sets column k to zero below its diagonal.
template <typename T>
[[gnu::always_inline]] inline void clear_below(T* swept, std::size_t k) {
  T* at = swept + packed_row(k) + k;
  for (std::size_t i = k + 1; i < kHorizon; ++i) {
    at += padded_row(i - 1);
    *at = T(0);
  }
}

/// Adds e[i] times row i of the lower triangle, which is also a column of M, to `column`.
/// @returns the inner product of e and the row left of its diagonal
template <typename T>
[[gnu::always_inline]] inline T add_product_of_row(const T* row, std::size_t i, const T* e, T* column) {
  T lanes[kPack] = {};  // NOLINT(modernize-avoid-c-arrays): scratch
  const T same = e[i];
  std::size_t j = 0;
  for (; j + kPack <= i; j += kPack) {
#pragma GCC unroll 4
    for (std::size_t l = 0; l < kPack; ++l) {
      lanes[l] = row[j + l] * e[j + l] + lanes[l];
    }
    if (same != T(0)) {  // nothing in column is -0, so that adding 0 changes no bit
#pragma GCC unroll 4
      for (std::size_t l = 0; l < kPack; ++l) {
        column[j + l] = row[j + l] * same + column[j + l];
      }
    }
  }
  for (std::size_t l = 0; j + l < i; ++l) {
    lanes[l] = row[j + l] * e[j + l] + lanes[l];
    column[j + l] = row[j + l] * same + column[j + l];
  }
  column[i] = row[i] * same + column[i];
  return (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
}

/// column += M e, from the lower triangle alone. Each row is read once. The order of the sums is the same on every
/// machine.
template <typename T>
[[gnu::always_inline]] inline void add_product(const T* swept, const T* e, T* column) {
  T row_part[kHorizon];  // NOLINT(modernize-avoid-c-arrays): scratch
  const T* row = swept;
  for (std::size_t i = 0; i < kHorizon; ++i) {
    row_part[i] = add_product_of_row(row, i, e, column);
    row += padded_row(i);
  }
  for (std::size_t i = 0; i < kHorizon; ++i) {
    column[i] += row_part[i];
  }
}

/// M += scaled pivot', the lower triangle of it.
template <typename T>
[[gnu::always_inline]] inline void add_outer_product(T* swept, const T* scaled, const T* pivot) {
  for (std::size_t b = 0; b < kHorizon; b += kPack) {  // four columns: their factors stay in registers
    const T in_registers[kPack] = {scaled[b], scaled[b + 1], scaled[b + 2], scaled[b + 3]};  // NOLINT
    T* part = swept + packed_row(b) + b;
    for (std::size_t i = b; i < kHorizon; i += kPack) {  // four rows of one length: its product is taken once
      const std::size_t length = padded_row(i);
#pragma GCC unroll 4
      for (std::size_t r = 0; r < kPack; ++r) {
        const T factor = pivot[i + r];
#pragma GCC unroll 4
        for (std::size_t l = 0; l < kPack; ++l) {
          part[l] = in_registers[l] * factor + part[l];
        }
        part += length;
      }
    }
  }
}

}  // namespace m100::mpc
