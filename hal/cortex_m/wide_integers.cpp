// SPDX-License-Identifier: BSD-3-Clause
// Converts 64-bit integers to floating point on a core with double-precision instructions. The compiler's library uses
// its software addition for that (1.5 kB, some sixty instructions each); these functions take a few instructions and
// round in the same way. The conversion from float to integer is for every core, because the library does it in double.
#include <bit>
#include <cstdint>

#if (__ARM_FP & 8) != 0

namespace {

constexpr double kPerHigh = 4294967296.0;  // 2^32

/// One rounding, in the sum: both terms are exact.
template <typename High>
[[gnu::always_inline]] inline double as_double(High high, std::uint32_t low) {
  return static_cast<double>(high) * kPerHigh + static_cast<double>(low);
}

/// Converts through a double, which must be exact: if there are more than 53 bits, the last twelve are reduced to one
/// sticky bit that tells whether any of them was set. A float has 24 bits, so its rounding does not change.
template <typename Wide>
[[gnu::always_inline]] inline float as_float(Wide value) {
  constexpr Wide kExact = Wide{1} << 53U;
  constexpr Wide kRest = 0xfff;
  const bool exact = value < kExact && (Wide(-1) > Wide(0) || value > -kExact);
  const Wide held = exact || (value & kRest) == 0 ? value : ((value & ~kRest) | (kRest + 1) / 2);
  const auto bits = static_cast<std::uint64_t>(held);
  const auto low = static_cast<std::uint32_t>(bits);
  if constexpr (Wide(-1) > Wide(0)) {
    return static_cast<float>(as_double(static_cast<std::uint32_t>(bits >> 32U), low));
  } else {
    return static_cast<float>(as_double(static_cast<std::int32_t>(bits >> 32U), low));
  }
}

}  // namespace

// Names and calling convention are those of the run-time ABI for the Arm architecture, 4.1.2.
extern "C" {
[[gnu::pcs("aapcs"), gnu::used]] double __aeabi_l2d(std::int64_t value) {
  const auto bits = static_cast<std::uint64_t>(value);
  return as_double(static_cast<std::int32_t>(bits >> 32U), static_cast<std::uint32_t>(bits));
}
[[gnu::pcs("aapcs"), gnu::used]] double __aeabi_ul2d(std::uint64_t value) {
  return as_double(static_cast<std::uint32_t>(value >> 32U), static_cast<std::uint32_t>(value));
}
[[gnu::pcs("aapcs"), gnu::used]] float __aeabi_l2f(std::int64_t value) { return as_float(value); }
[[gnu::pcs("aapcs"), gnu::used]] float __aeabi_ul2f(std::uint64_t value) { return as_float(value); }
}

#endif

extern "C" {
/// Rounds towards zero. A value out of range is undefined behaviour in the language; here it gives the nearest limit.
[[gnu::pcs("aapcs"), gnu::used]] std::int64_t __aeabi_f2lz(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::int32_t exponent = static_cast<std::int32_t>((bits >> 23U) & 0xFFU) - 127;
  const bool negative = (bits >> 31U) != 0;
  if (exponent < 31) {
    return static_cast<std::int32_t>(value);  // one instruction of the processor
  }
  if (exponent > 62) {
    return negative ? INT64_MIN : INT64_MAX;
  }
  const std::int64_t size = static_cast<std::int64_t>((bits & 0x7FFFFFU) | 0x800000U) << (exponent - 23);
  return negative ? -size : size;
}
}
