// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/core/maths.h"
#include "host_tests/golden/number_hash.h"

namespace m100::golden {

/// Fixed arguments from an integer generator, so that they do not depend on the floating-point arithmetic of the
/// machine.
template <typename T>
class Arguments {
 public:
  /// Uniform in [-bound, bound) on 24 bits, exact in float and double.
  T next(T bound) {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    const auto bits = static_cast<std::int32_t>(state_ >> 40U) - (1 << 23);
    return static_cast<T>(bits) / static_cast<T>(1 << 23) * bound;
  }

 private:
  std::uint64_t state_{20171122};
};

/// One hash over the results of every function of core/maths.h.
/// Cost: about 20 functions' calls for each of `rounds`.
template <typename T>
HashText maths_sweep(int rounds) {
  Arguments<T> arguments;
  NumberHash hash;
  for (int i = 0; i < rounds; ++i) {
    for (const T bound : {T(1e-3), T(0.8), T(7), T(1e5)}) {
      const T x = arguments.next(bound);
      const T y = arguments.next(bound);
      hash.append(core::sin(x));
      hash.append(core::cos(x));
      hash.append(core::tan(y));
      hash.append(core::atan2(y, x));
      hash.append(core::asin(x));
      hash.append(core::exp(x));
      hash.append(core::sqrt(y));
      hash.append(core::wrap_pi(x));
    }
  }
  return hash.finish();
}

/// Number of rounds and the published hashes: computed once on x86-64, and the same on every machine since then.
inline constexpr int kSweepRounds = 2000;
inline constexpr std::string_view kSweepOfDouble = "6439f90f7a51de54870788ab9d66d091facb72130127c5d0df2dd813ce7500ff";
inline constexpr std::string_view kSweepOfFloat = "13648c93e7c75f816a2f8eba27ea70e36b5e64f2835ebc4ffcab0816038398e8";

}  // namespace m100::golden
