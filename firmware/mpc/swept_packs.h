// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/lanes.h"

// The operations of swept.h for registers that hold a pack of four numbers: all loops are unrolled, so that every
// address is a constant, or a constant plus the number of a column.
namespace m100::mpc::M100_LANES_NAMESPACE {

/// gather() for a column of block kBlock.
template <std::size_t kBlock, typename T>
M100_INLINE void gather_in_block(const T* swept, std::size_t k, T* pivot) {
  static_assert(kHorizon / kPack == 5);
  const T* row = swept + packed_row(kBlock * kPack) + (k % kPack) * (kPack * (kBlock + 1));
  M100_UNROLL(5)
  for (std::size_t b = 0; b <= kBlock; ++b) {
    store<T>(pivot + b * kPack, load(row + b * kPack));
  }
  M100_UNROLL(20)
  for (std::size_t i = kBlock * kPack + 1; i < kHorizon; ++i) {
    if (i >= (kBlock + 1) * kPack || i > k) {
      pivot[i] = swept[packed_row(i) + k];
    }
  }
  pin_in_memory(pivot);
}

/// pivot = column k: row k up to the diagonal, then down the rows.
template <typename T>
M100_INLINE void gather(const T* swept, std::size_t k, T* pivot) {
  switch (k / kPack) {
    case 0:
      return gather_in_block<0>(swept, k, pivot);
    case 1:
      return gather_in_block<1>(swept, k, pivot);
    case 2:
      return gather_in_block<2>(swept, k, pivot);
    case 3:
      return gather_in_block<3>(swept, k, pivot);
    default:
      return gather_in_block<4>(swept, k, pivot);
  }
}

/// clear_below() for a column of block kBlock.
template <std::size_t kBlock, typename T>
M100_INLINE void clear_below_in_block(T* swept, std::size_t k) {
  M100_UNROLL(20)
  for (std::size_t i = kBlock * kPack + 1; i < kHorizon; ++i) {
    if (i >= (kBlock + 1) * kPack || i > k) {
      swept[packed_row(i) + k] = T(0);
    }
  }
}

/// Sets column k to zero below its diagonal.
template <typename T>
M100_INLINE void clear_below(T* swept, std::size_t k) {
  switch (k / kPack) {
    case 0:
      return clear_below_in_block<0>(swept, k);
    case 1:
      return clear_below_in_block<1>(swept, k);
    case 2:
      return clear_below_in_block<2>(swept, k);
    case 3:
      return clear_below_in_block<3>(swept, k);
    default:
      return clear_below_in_block<4>(swept, k);
  }
}

/// column += M e, from the lower triangle alone. Each row is read once. The order of the sums is the same on every
/// machine.
template <typename T>
M100_INLINE void add_product(const T* swept, const T* e, T* column) {
  Column<T> factor;
  Column<T> sum;
  Column<T> lanes;
  factor.read(e);
  sum.read(column);
  const Pack<T> zero = spread(T(0));
  const Pack<T> place = load(kCount<T>.data());
  M100_UNROLL(5)
  for (std::size_t block = 0; block < kColumnPacks; ++block) {
    Pack<T> part_of_row[kPack];  // NOLINT(modernize-avoid-c-arrays): registers
    M100_UNROLL(4)
    for (std::size_t r = 0; r < kPack; ++r) {
      const T* row = swept + packed_row(block * kPack + r);
      const Pack<T> same = spread(e[block * kPack + r]);
      const Pack<T> diagonal = spread(T(r));
      Pack<T> in_lanes = zero;
      M100_UNROLL(5)
      for (std::size_t b = 0; b < block; ++b) {
        const Pack<T> part = load(row + b * kPack);
        in_lanes = part * factor.pack[b] + in_lanes;
        sum.pack[b] = part * same + sum.pack[b];
      }
      const Pack<T> last = load(row + block * kPack);
      part_of_row[r] = choose<T>(is_below<T>(place, diagonal), last, zero) * factor.pack[block] + in_lanes;
      sum.pack[block] = choose<T>(is_at_most<T>(place, diagonal), last, zero) * same + sum.pack[block];
    }
    lanes.pack[block] = sums_of<T>(part_of_row[0], part_of_row[1], part_of_row[2], part_of_row[3]);
  }
  M100_UNROLL(5)
  for (std::size_t b = 0; b < kColumnPacks; ++b) {
    store<T>(column + b * kPack, sum.pack[b] + lanes.pack[b]);
  }
}

/// M += scaled pivot', the lower triangle of it.
template <typename T>
M100_INLINE void add_outer_product(T* swept, const T* scaled, const T* pivot) {
  Column<T> factors;
  factors.read(scaled);
  M100_UNROLL(20)
  for (std::size_t i = 0; i < kHorizon; ++i) {
    T* row = swept + packed_row(i);
    const Pack<T> same = spread(pivot[i]);
    M100_UNROLL(20)
    for (std::size_t b = 0; b < i / kLanes + 1; ++b) {
      store<T>(row + b * kLanes, factors.pack[b] * same + load(row + b * kLanes));
    }
  }
}

}  // namespace m100::mpc::M100_LANES_NAMESPACE
