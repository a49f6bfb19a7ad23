// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/columns.h"
#include "firmware/mpc/gain_table.h"

namespace m100::mpc {

/// Guesses the active set: each input is clipped in turn, and the later ones are re-optimised for it (by one column of
/// the Cholesky factor of H^-1 each). Right in half of all problems, near in most. `inputs` is scratch.
/// @param side receives +1 at the upper limit, -1 at the lower, 0 free.
/// @returns one bit for each active input.
template <typename T>
inline std::uint32_t guess_by_clipping(const GainTable<T>& table, const Column<T>& unconstrained, T low_slope,
                                       T high_slope, Column<T>& inputs, Column<T>& side) {
  std::uint32_t active = 0;
  inputs = unconstrained;
  const T* gain = table.clipping_gain.data();
  for (std::size_t i = 0; i < kHorizon; ++i) {
    const std::size_t first = i - i % kPack;
    const T value = inputs[i];
    side[i] = T(0);
    if (value > high_slope || value < low_slope) {
      side[i] = value > high_slope ? T(1) : T(-1);
      active |= 1U << i;
      const T away = (value > high_slope ? high_slope : low_slope) - value;
      for (std::size_t j = first; j < kHorizon; ++j) {
        inputs[j] = gain[j - first] * away + inputs[j];
      }
    }
    gain += kHorizon - first;
  }
  return active;
}

}  // namespace m100::mpc
