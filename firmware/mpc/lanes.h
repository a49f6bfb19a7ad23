// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/mpc/packs.h"

// Columns of 20 numbers in packs. Sums over columns are taken in the order of the columns, so the bits of a result do
// not depend on how many lanes the machine has.
namespace m100::mpc::M100_LANES_NAMESPACE {

/// 20 numbers in registers.
template <typename T>
struct Column {
  Pack<T> pack[kColumnPacks];  // NOLINT(modernize-avoid-c-arrays): an std::array would not stay in registers at -O1

  M100_INLINE void add(const T* column, T factor) {
    const Pack<T> same = spread(factor);
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      pack[i] = load(column + i * kLanes) * same + pack[i];
    }
  }
  M100_INLINE void set(const T* column, T factor) {
    const Pack<T> same = spread(factor);
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      pack[i] = load(column + i * kLanes) * same;
    }
  }
  M100_INLINE void read(const T* column) {
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      pack[i] = load(column + i * kLanes);
    }
  }
  M100_INLINE void write(T* column) const {
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      store<T>(column + i * kLanes, pack[i]);
    }
  }
};

/// to = from * factor, both in memory: with a Column, a machine without packs would write 20 numbers twice.
template <typename T>
M100_INLINE void scale_column(T* to, const T* from, T factor) {
  const Pack<T> same = spread(factor);
  M100_UNROLL_IN_MEMORY
  for (std::size_t b = 0; b < kColumnPacks; ++b) {
    store<T>(to + b * kLanes, load(from + b * kLanes) * same);
  }
}

/// to += column * factor, both in memory, see scale_column().
template <typename T>
M100_INLINE void add_column(T* to, const T* column, T factor) {
  const Pack<T> same = spread(factor);
  M100_UNROLL_IN_MEMORY
  for (std::size_t b = 0; b < kColumnPacks; ++b) {
    store<T>(to + b * kLanes, load(column + b * kLanes) * same + load(to + b * kLanes));
  }
}

/// sum += columns[i * stride + j] * factors[i] for all j, in the order of i < count.
#ifdef M100_LANES_SCALAR
template <typename T>
__attribute__((noinline)) void add_columns(Column<T>& sum, const T* columns, std::size_t stride, const T* factors,
                                           std::size_t count) {
  Column<T> in_registers = sum;
  for (std::size_t i = 0; i < count; ++i) {
    const T factor = factors[i];
    M100_PRAGMA(GCC unroll 20)
    for (std::size_t j = 0; j < kHorizon; ++j) {
      in_registers.pack[j] = columns[j] * factor + in_registers.pack[j];
    }
    columns += stride;
  }
  sum = in_registers;
}
#else
template <typename T>
M100_INLINE void add_columns(Column<T>& sum, const T* columns, std::size_t stride, const T* factors,
                             std::size_t count) {
  M100_UNROLL(20)
  for (std::size_t i = 0; i < count; ++i) {
    sum.add(columns + i * stride, factors[i]);
  }
}
#endif

/// The numbers 0, 1, 2, ...
template <typename T>
inline constexpr std::array<T, kHorizon> kCount{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19};

/// The largest of 20 numbers above a floor, and its first index; kHorizon if none is above the floor. A NaN is never
/// the largest. The result does not depend on the number of lanes.
template <typename T>
class Largest {
 public:
  M100_INLINE explicit Largest(T floor) : value_(spread(floor)), place_(spread(T(kHorizon))) {}

  M100_INLINE void consider(const Pack<T>& value, std::size_t pack) {
    const Pack<T> place = load(kCount<T>.data() + pack * kLanes);
    const Mask<T> better = is_below<T>(value_, value);
    value_ = choose<T>(better, value, value_);
    place_ = choose<T>(better, place, place_);
  }
  /// @returns the first index of the largest number; kHorizon if none is above the floor.
  M100_INLINE std::size_t found() {
#ifdef M100_LANES_SCALAR
    return static_cast<std::size_t>(place_);
#else
    T best = value_[0];
    T place = place_[0];
    M100_UNROLL(4)
    for (std::size_t lane = 1; lane < kLanes; ++lane) {
      const bool better = value_[lane] > best || (value_[lane] == best && place_[lane] < place);
      best = better ? value_[lane] : best;
      place = better ? place_[lane] : place;
    }
    return static_cast<std::size_t>(static_cast<int>(place));
#endif
  }

 private:
  Pack<T> value_;
  Pack<T> place_;
};

/// Numbers written to memory stay there: without this the compilers take them out of vector registers one by one.
M100_INLINE void pin_in_memory(const void* memory) { asm volatile("" : : "r"(memory) : "memory"); }

}  // namespace m100::mpc::M100_LANES_NAMESPACE
