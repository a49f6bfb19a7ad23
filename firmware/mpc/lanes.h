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

// Loops over packs are unrolled where registers are wide; where they are not, seventy kilobytes of flash go into it and
// the loop counter costs less than the instruction cache.
#define M100_PRAGMA(text) _Pragma(#text)
#ifdef M100_LANES_SCALAR
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
  return *reinterpret_cast<const typename PackOf<T>::Memory*>(from);
}
template <typename T>
M100_INLINE void store(T* to, const Pack<T>& pack) {
  *reinterpret_cast<typename PackOf<T>::Memory*>(to) = pack;
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
#pragma GCC unroll 20
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      pack[i] += load(column + i * kLanes) * factor;
    }
  }
  M100_INLINE void set(const T* column, T factor) {
#pragma GCC unroll 20
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      pack[i] = load(column + i * kLanes) * factor;
    }
  }
  M100_INLINE void read(const T* column) {
#pragma GCC unroll 20
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      pack[i] = load(column + i * kLanes);
    }
  }
  M100_INLINE void write(T* column) const {
#pragma GCC unroll 20
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      store<T>(column + i * kLanes, pack[i]);
    }
  }
};

}  // namespace m100::mpc::M100_LANES_NAMESPACE
