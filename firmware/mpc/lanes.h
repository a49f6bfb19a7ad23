// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/mpc/gain_table.h"

// Columns of 20 numbers in lanes. Every operation here works element by element, and sums over columns are taken in the
// order of the columns, so the bits of a result do not depend on how many lanes the machine has (promise R6).
//
// Everything is in a namespace of its own per instruction set: the same templates compiled with wider registers are
// different functions, and the linker cannot mix them up.
#if defined(__AVX__)
#define M100_LANES_NAMESPACE avx
#elif defined(__SSE2__) || defined(__ARM_NEON)
#define M100_LANES_NAMESPACE simd
#else
#define M100_LANES_NAMESPACE scalar
#define M100_LANES_SCALAR 1
#endif

#define M100_INLINE inline __attribute__((always_inline))

// Loops over packs are unrolled where registers are wide; where they are not, only that of add_columns() is, which is
// one function there: seventy kilobytes of flash would go into unrolling all.
#define M100_PRAGMA(text) _Pragma(#text)
#if defined(__SANITIZE_ADDRESS__)
#define M100_UNROLL(times)  // the instrumented loop is no longer one that GCC can annotate
#elif defined(M100_LANES_SCALAR)
#define M100_UNROLL(times) M100_PRAGMA(GCC unroll 1)
#else
#define M100_UNROLL(times) M100_PRAGMA(GCC unroll times)
#endif

namespace m100::mpc::M100_LANES_NAMESPACE {

template <typename T>
struct PackOf;

#ifdef M100_LANES_SCALAR
inline constexpr std::size_t kLanes = 1;
template <>
struct PackOf<float> {
  using Type = float;
  using Memory = float;
  using Mask = bool;
};
template <>
struct PackOf<double> {
  using Type = double;
  using Memory = double;
  using Mask = bool;
};
template <typename M>
M100_INLINE bool all_of(M mask) {
  return mask;
}
#else
inline constexpr std::size_t kLanes = kPack;
template <>
struct PackOf<float> {
  using Type = float __attribute__((vector_size(16)));
  using Memory = float __attribute__((vector_size(16), aligned(4), may_alias));
  using Mask = std::int32_t __attribute__((vector_size(16)));
};
template <>
struct PackOf<double> {
  using Type = double __attribute__((vector_size(32)));
  using Memory = double __attribute__((vector_size(32), aligned(8), may_alias));
  using Mask = std::int64_t __attribute__((vector_size(32)));
};
template <typename M>
M100_INLINE bool all_of(const M& mask) {
  return ((mask[0] & mask[1]) & (mask[2] & mask[3])) != 0;
}
#endif

template <typename T>
using Pack = typename PackOf<T>::Type;
template <typename T>
using Mask = typename PackOf<T>::Mask;

inline constexpr std::size_t kColumnPacks = kHorizon / kLanes;

template <typename T>
M100_INLINE Pack<T> load(const T* from) {
  Pack<T> pack;
  __builtin_memcpy(&pack, from, sizeof(pack));  // unaligned; Clang drops the alignment of a type named by a template
  return pack;
}
template <typename T>
M100_INLINE void store(T* to, const Pack<T>& pack) {
  __builtin_memcpy(to, &pack, sizeof(pack));
}
template <typename T>
M100_INLINE Pack<T> spread(T value) {
  return Pack<T>{} + value;
}

/// 20 numbers in registers.
template <typename T>
struct Column {
  Pack<T> pack[kColumnPacks];  // NOLINT(modernize-avoid-c-arrays): an std::array would not stay in registers at -O1

  M100_INLINE void add(const T* column, T factor) {
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      pack[i] += load(column + i * kLanes) * factor;
    }
  }
  M100_INLINE void set(const T* column, T factor) {
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      pack[i] = load(column + i * kLanes) * factor;
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
      in_registers.pack[j] += columns[j] * factor;
    }
    columns += stride;
  }
  sum = in_registers;
}
#else
template <typename T>
M100_INLINE void add_columns(Column<T>& sum, const T* columns, std::size_t stride, const T* factors,
                             std::size_t count) {
  M100_UNROLL(5)  // all 20 at once, and the compiler loads ahead until it spills
  for (std::size_t i = 0; i < count; ++i) {
    sum.add(columns + i * stride, factors[i]);
  }
}
#endif

/// The numbers 0, 1, 2, ...
template <typename T>
inline constexpr std::array<T, kHorizon> kCount{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19};

/// The largest of 20 numbers above a floor, and the first place where it stands; kHorizon when none is above the floor.
/// A NaN is never the largest. The answer does not depend on the number of lanes.
template <typename T>
class Largest {
 public:
  M100_INLINE explicit Largest(T floor) : value_(spread(floor)), place_(spread(T(kHorizon))) {}

  M100_INLINE void consider(const Pack<T>& value, std::size_t pack) {
    const Pack<T> place = load(kCount<T>.data() + pack * kLanes);
    const Mask<T> better = value > value_;
    value_ = better ? value : value_;
    place_ = better ? place : place_;
  }
  /// @returns the place.
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
M100_INLINE void settle(const void* memory) { asm volatile("" : : "r"(memory) : "memory"); }

}  // namespace m100::mpc::M100_LANES_NAMESPACE
