// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/lanes.h"

namespace m100::mpc::M100_LANES_NAMESPACE {

/// Guesses the active set: each input is clipped in turn, and the later ones are re-optimised for it (by one column of
/// the Cholesky factor of H^-1 each). Right in half of all problems, near in most. All arrays hold 20 numbers; `inputs`
/// is scratch.
/// @param side receives +1 at the upper limit, -1 at the lower, 0 free.
/// @returns one bit for each active input.
template <typename T>
M100_INLINE std::uint32_t guess_by_clipping(const GainTable<T>& table, const T* unconstrained, T low_rad, T high_rad,
                                            T* inputs, T* side) {
  std::uint32_t active = 0;
  Column<T> sum;
  sum.read(unconstrained);
  sum.write(inputs);
  const T* gain = table.clipping_gain.data();
  M100_UNROLL(20)
  for (std::size_t i = 0; i < kHorizon; ++i) {
    const std::size_t block = i / kPack;
    const T value = inputs[i];
    side[i] = T(0);
    if (value > high_rad || value < low_rad) {
      side[i] = value > high_rad ? T(1) : T(-1);
      active |= 1U << i;
      const Pack<T> away = spread((value > high_rad ? high_rad : low_rad) - value);
      M100_UNROLL(20)
      for (std::size_t b = block * kPack / kLanes; b < kColumnPacks; ++b) {
        store<T>(inputs + b * kLanes, load(gain + (b * kLanes - block * kPack)) * away + load(inputs + b * kLanes));
      }
    }
    gain += kHorizon - block * kPack;
  }
  return active;
}

}  // namespace m100::mpc::M100_LANES_NAMESPACE
