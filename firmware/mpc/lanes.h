// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/mpc/gain_table.h"

#ifdef __SSE2__
#include <immintrin.h>
#endif

// Columns of 20 numbers in lanes. Every operation here works element by element, and sums over columns are taken in the
// order of the columns, so the bits of a result do not depend on how many lanes the machine has (promise R6). A product
// that is added is rounded before (-ffp-contract=off): a fused multiply-add would save an instruction where the machine
// has one, and where it has none each product would be a call into the compiler's library to have the same bits.
//
// Everything is in a namespace of its own per instruction set: the same templates compiled with wider registers are
// different functions, and the linker cannot mix them up.
#ifdef __AVX2__
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
  using Memory = float __attribute__((vector_size(16), aligned(4), may_alias));
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
/// Registers hold two doubles. Of a vector type of four the compilers keep every value in memory.
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

// What the packs' operators would say, lane by lane; comparisons with a number that is none do not hold.
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
/// a where the mask is set, else b.
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

/// The largest lane; not a number only if a lane is not.
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

/// The largest of 20 numbers above a floor, and the first place where it stands; kHorizon when none is above the floor.
/// A NaN is never the largest. The answer does not depend on the number of lanes.
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
