// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/mpc/gain_table.h"

#ifdef __SSE2__
#include <immintrin.h>
#endif

// Packs: four numbers on machines with vector registers, otherwise one. Every operation but largest_of() and sums_of()
// works element by element, so the bits of a result do not depend on the number of lanes (R6). Products are rounded
// before they are added (-ffp-contract=off): a fused multiply-add would save an instruction on machines that have one,
// but on machines without one each product would be a call into the compiler's library to get the same bits.
//
// Each instruction set has a namespace of its own: the same templates compiled with wider registers are different
// functions, and the linker cannot mix them up.
#ifdef __AVX2__
#define M100_LANES_NAMESPACE avx
#elif defined(__SSE2__) || defined(__ARM_NEON)
#define M100_LANES_NAMESPACE simd
#else
#define M100_LANES_NAMESPACE scalar
#define M100_LANES_SCALAR 1
#endif

#define M100_INLINE inline __attribute__((always_inline))

// Loops over packs are unrolled on machines with wide registers. On others only the loop of add_columns() is unrolled
// whole, which is one function there: unrolling all would cost seventy kilobytes of flash.
#define M100_PRAGMA(text) _Pragma(#text)
#if defined(M100_SANITIZED)
#define M100_UNROLL(times)  // an instrumented loop is not one that a compiler can unroll
#elif defined(M100_LANES_SCALAR)
#define M100_UNROLL(times) M100_PRAGMA(GCC unroll 1)
#else
#define M100_UNROLL(times) M100_PRAGMA(GCC unroll times)
#endif
/// With one number per register, the work for one change of the active set is a function of its own: inlining it at
/// every place that changes the set would cost five kilobytes of flash.
#ifdef M100_LANES_SCALAR
#define M100_INLINE_PACKS __attribute__((noinline))
#else
#define M100_INLINE_PACKS M100_INLINE
#endif
// The short loops of every change of the active set: with one number per register, four numbers per iteration.
#ifdef M100_LANES_SCALAR
#define M100_UNROLL_IN_MEMORY M100_PRAGMA(GCC unroll 4)
#else
#define M100_UNROLL_IN_MEMORY M100_UNROLL(20)
#endif

namespace m100::mpc::M100_LANES_NAMESPACE {

template <typename T>
struct PackOf;

#ifdef M100_LANES_SCALAR
inline constexpr std::size_t kLanes = 1;
template <>
struct PackOf<float> {
  using Type = float;
  using Mask = bool;
};
template <>
struct PackOf<double> {
  using Type = double;
  using Mask = bool;
};
/// One bit for each lane, the first in the lowest.
template <typename T>
M100_INLINE std::uint32_t bits_of(bool mask) {
  return mask ? 1U : 0U;
}
#else
inline constexpr std::size_t kLanes = kPack;
template <>
struct PackOf<float> {
  using Type = float __attribute__((vector_size(16)));
  using Mask = std::int32_t __attribute__((vector_size(16)));
};
#ifdef __AVX2__
template <>
struct PackOf<double> {
  using Type = double __attribute__((vector_size(32)));
  using Mask = std::int64_t __attribute__((vector_size(32)));
};
template <typename T>
inline constexpr bool kHalved = false;
#else
/// Registers hold two doubles. With a vector type of four doubles the compilers keep every value in memory.
struct DoubleMask {
  using Half = std::int64_t __attribute__((vector_size(16)));
  Half low, high;
  M100_INLINE std::int64_t operator[](std::size_t lane) const { return lane < 2 ? low[lane] : high[lane - 2]; }
  M100_INLINE friend DoubleMask operator&(const DoubleMask& a, const DoubleMask& b) {
    return {a.low & b.low, a.high & b.high};
  }
  M100_INLINE friend DoubleMask operator|(const DoubleMask& a, const DoubleMask& b) {
    return {a.low | b.low, a.high | b.high};
  }
};
struct DoublePack {
  using Half = double __attribute__((vector_size(16)));
  Half low, high;
  M100_INLINE friend DoublePack operator+(const DoublePack& a, const DoublePack& b) {
    return {a.low + b.low, a.high + b.high};
  }
  M100_INLINE friend DoublePack operator-(const DoublePack& a, const DoublePack& b) {
    return {a.low - b.low, a.high - b.high};
  }
  M100_INLINE friend DoublePack operator*(const DoublePack& a, const DoublePack& b) {
    return {a.low * b.low, a.high * b.high};
  }
  M100_INLINE DoublePack operator-() const { return {-low, -high}; }
  M100_INLINE double operator[](std::size_t lane) const { return lane < 2 ? low[lane] : high[lane - 2]; }
};
template <>
struct PackOf<double> {
  using Type = DoublePack;
  using Mask = DoubleMask;
};
template <typename T>
inline constexpr bool kHalved = sizeof(T) == sizeof(double);
#endif
template <typename T>
M100_INLINE std::uint32_t bits_of(const typename PackOf<T>::Mask& mask) {
#ifdef __SSE2__
  if constexpr (kHalved<T>) {
    const int low = _mm_movemask_pd(__builtin_bit_cast(__m128d, mask.low));
    return static_cast<std::uint32_t>(low | _mm_movemask_pd(__builtin_bit_cast(__m128d, mask.high)) << 2);
#ifdef __AVX2__
  } else if constexpr (sizeof(T) == sizeof(double)) {
    return static_cast<std::uint32_t>(_mm256_movemask_pd(__builtin_bit_cast(__m256d, mask)));
#endif
  } else {
    return static_cast<std::uint32_t>(_mm_movemask_ps(__builtin_bit_cast(__m128, mask)));
  }
#else
  return static_cast<std::uint32_t>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}
#endif

template <typename T>
using Pack = typename PackOf<T>::Type;
template <typename T>
using Mask = typename PackOf<T>::Mask;

inline constexpr std::size_t kColumnPacks = kHorizon / kLanes;
inline constexpr std::uint32_t kAllLanes = (1U << kLanes) - 1;

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
#ifdef M100_LANES_SCALAR
  return value;
#else
  if constexpr (kHalved<T>) {
    return Pack<T>{{value, value}, {value, value}};
  } else {
    return Pack<T>{value, value, value, value};  // not Pack{} + value: that addition would stay, for the sake of -0
  }
#endif
}

// Comparisons of packs, lane by lane; a comparison with NaN is false.
#ifdef M100_LANES_SCALAR
#define M100_LANEWISE(name, expression) \
  template <typename T>                 \
  M100_INLINE bool name(T a, T b) {     \
    return expression;                  \
  }
template <typename T>
M100_INLINE T choose(bool mask, T a, T b) {
  return mask ? a : b;
}
#else
#define M100_LANEWISE(name, expression)                                                                           \
  template <typename T>                                                                                           \
  M100_INLINE Mask<T> name(const Pack<T>& x, const Pack<T>& y) {                                                  \
    const auto compared = [](const auto& a, const auto& b) __attribute__((always_inline)) { return expression; }; \
    if constexpr (kHalved<T>) {                                                                                   \
      return Mask<T>{compared(x.low, y.low), compared(x.high, y.high)};                                           \
    } else {                                                                                                      \
      return compared(x, y);                                                                                      \
    }                                                                                                             \
  }
/// a where the mask is set, otherwise b.
template <typename T>
M100_INLINE Pack<T> choose(const Mask<T>& mask, const Pack<T>& a, const Pack<T>& b) {
  if constexpr (kHalved<T>) {
    return Pack<T>{mask.low ? a.low : b.low, mask.high ? a.high : b.high};
  } else {
    return mask ? a : b;
  }
}
#endif
M100_LANEWISE(is_below, a < b)
M100_LANEWISE(is_at_most, a <= b)
M100_LANEWISE(is_equal, a == b)
#undef M100_LANEWISE

template <typename T>
M100_INLINE Pack<T> larger(const Pack<T>& a, const Pack<T>& b) {
  return choose<T>(is_below<T>(b, a), a, b);
}
template <typename T>
M100_INLINE Pack<T> smaller(const Pack<T>& a, const Pack<T>& b) {
  return choose<T>(is_below<T>(a, b), a, b);
}

/// The largest lane; NaN only if a lane is NaN.
template <typename T>
M100_INLINE T largest_of(const Pack<T>& pack) {
#ifdef M100_LANES_SCALAR
  return pack;
#else
  const T a = pack[0] > pack[2] ? pack[0] : pack[2];
  const T b = pack[1] > pack[3] ? pack[1] : pack[3];
  return a > b ? a : b;
#endif
}

#ifndef M100_LANES_SCALAR
/// The sum of the lanes of each of four packs, (0 + 2) + (1 + 3).
template <typename T>
M100_INLINE Pack<T> sums_of(const Pack<T>& a, const Pack<T>& b, const Pack<T>& c, const Pack<T>& d) {
  if constexpr (kHalved<T>) {
    const auto pair = [](const auto& x, const auto& y) __attribute__((always_inline)) {
      return __builtin_shufflevector(x, y, 0, 2) + __builtin_shufflevector(x, y, 1, 3);
    };
    return {pair(a.low + a.high, b.low + b.high), pair(c.low + c.high, d.low + d.high)};
  } else {
    const Pack<T> even_ab = __builtin_shufflevector(a, b, 0, 4, 2, 6);
    const Pack<T> even_cd = __builtin_shufflevector(c, d, 0, 4, 2, 6);
    const Pack<T> odd_ab = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Pack<T> odd_cd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    const Pack<T> even =
        __builtin_shufflevector(even_ab, even_cd, 0, 1, 4, 5) + __builtin_shufflevector(even_ab, even_cd, 2, 3, 6, 7);
    const Pack<T> odd =
        __builtin_shufflevector(odd_ab, odd_cd, 0, 1, 4, 5) + __builtin_shufflevector(odd_ab, odd_cd, 2, 3, 6, 7);
    return even + odd;
  }
}
#endif

}  // namespace m100::mpc::M100_LANES_NAMESPACE
