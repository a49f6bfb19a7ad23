// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/horizontal_mpc.h"
#include "firmware/mpc/lanes.h"

// The four operations of the active-set iteration on the swept tableau, a symmetric 20 x 20 matrix of which the lower
// triangle is kept (gain_table.h): gather() reads a column, clear_below() sets a column to zero below the diagonal,
// add_product() multiplies by a vector, add_outer_product() adds the product of two vectors. One version is for
// machines with vector registers, one for machines without. Both give the same bits.
#ifdef M100_LANES_SCALAR
#include "firmware/mpc/swept_scalar.h"
#else
#include "firmware/mpc/swept_packs.h"
#endif

namespace m100::mpc::M100_LANES_NAMESPACE {

/// The tableau of the empty active set: H^-1, every input free.
template <typename T>
M100_INLINE void start_over(const GainTable<T>& table, Tableau<T>& tableau) {
  M100_UNROLL(8)
  for (std::size_t i = 0; i < kPackedSize; i += kLanes) {
    store<T>(tableau.swept.data() + i, load(table.inverse_hessian.data() + i));
  }
  M100_UNROLL(5)
  for (std::size_t i = 0; i < kHorizon; i += kLanes) {
    store<T>(tableau.side.data() + i, spread(T(0)));
  }
}

/// The tableau of the full active set: -H. Leaves the sides to the caller.
template <typename T>
M100_INLINE void start_full(const GainTable<T>& table, Tableau<T>& tableau) {
  M100_UNROLL(20)
  for (std::size_t i = 0; i < kHorizon; ++i) {
    M100_UNROLL(20)
    for (std::size_t b = 0; b < i / kLanes + 1; ++b) {
      store<T>(tableau.swept.data() + packed_row(i) + b * kLanes,
               -load(table.hessian.data() + i * kHorizon + b * kLanes));
    }
  }
}

}  // namespace m100::mpc::M100_LANES_NAMESPACE
