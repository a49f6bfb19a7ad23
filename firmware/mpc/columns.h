// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/mpc/problem.h"

// Operations on columns of 20 numbers. Sums over columns are taken in the order of the columns, and products are
// rounded before they are added (-ffp-contract=off), so the bits of a result are the same on every machine (R6).
namespace m100::mpc {

template <typename T>
using Column = std::array<T, kHorizon>;

/// sum += columns[i * stride + j] * factors[i] for all j, in the order of i < count. One function with its inner loop
/// unrolled whole: unrolling it wherever it is used would cost seventy kilobytes of flash.
template <typename T>
[[gnu::noinline]] void add_columns(Column<T>& sum, const T* columns, std::size_t stride, const T* factors,
                                   std::size_t count) {
  Column<T> in_registers = sum;
  for (std::size_t i = 0; i < count; ++i) {
    const T factor = factors[i];
#pragma GCC unroll 20
    for (std::size_t j = 0; j < kHorizon; ++j) {
      in_registers[j] = columns[j] * factor + in_registers[j];
    }
    columns += stride;
  }
  sum = in_registers;
}

/// to += column * factor
template <typename T>
[[gnu::always_inline]] inline void add_column(Column<T>& to, const T* column, T factor) {
#pragma GCC unroll 4
  for (std::size_t i = 0; i < kHorizon; ++i) {
    to[i] = column[i] * factor + to[i];
  }
}

/// to = column * factor
template <typename T>
[[gnu::always_inline]] inline void scale_column(Column<T>& to, const T* column, T factor) {
#pragma GCC unroll 4
  for (std::size_t i = 0; i < kHorizon; ++i) {
    to[i] = column[i] * factor;
  }
}

}  // namespace m100::mpc
