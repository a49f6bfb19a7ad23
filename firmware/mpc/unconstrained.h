// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/lanes.h"

namespace m100::mpc::M100_LANES_NAMESPACE {

/// Room for the taps to run over the end of the horizon, where everything is zero.
inline constexpr std::size_t kPadded = kHorizon + 2 * kPack;

template <typename T>
M100_INLINE void zero_tail(T* padded) {
  for (std::size_t i = kHorizon; i < kHorizon + kMaxStates; ++i) {
    padded[i] = T(0);
  }
}

/// sum += taps[m] * signal[j + m] for all j, m < count.
template <typename T, std::size_t kCount>
M100_INLINE void filter(Column<T>& sum, const T* signal, const T* taps) {
  add_columns(sum, signal, 1, taps, kCount);
}

/// g of gain_table.h into `filtered`.
template <typename T, std::size_t kStates, bool kConstantTargets>
M100_INLINE void filter_references(const GainTable<T>& table, const Problem<T>& problem, T origin_m, T* filtered) {
  alignas(32) T padded[kPadded];  // NOLINT(modernize-avoid-c-arrays): scratch, not initialised on purpose
  Column<T> signal;
  Column<T> sum;
  zero_tail(padded);
  signal.read(problem.position_ref_m.data());
  M100_UNROLL(20)
  for (std::size_t i = 0; i < kColumnPacks; ++i) {
    signal.pack[i] -= origin_m;
  }
  signal.write(padded);
  sum.set(padded, table.position_taps[0]);
  filter<T, kStates - 1>(sum, padded + 1, table.position_taps.data() + 1);

  signal.read(problem.velocity_ref_m_s.data());
  signal.write(padded);
  filter<T, kStates>(sum, padded, table.velocity_taps.data());
  const T last_velocity_m_s = problem.velocity_ref_m_s[kHorizon - 1];
  if constexpr (!kConstantTargets) {
    signal.read(problem.tilt_ref_rad.data());
    signal.write(padded);
    filter<T, kStates>(sum, padded, table.tilt_taps.data());
    signal.read(problem.input_ref_rad.data());
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      signal.pack[i] += problem.input_offset_rad;
    }
    signal.write(padded);
    filter<T, kStates + 1>(sum, padded, table.input_taps.data());
  }
  sum.write(filtered);
  filtered[0] += table.rate_weight * (problem.previous_input_rad + problem.input_offset_rad);
  M100_UNROLL(4)
  for (std::size_t m = 0; m < kStates; ++m) {
    T last = table.terminal_velocity_taps[m] * last_velocity_m_s;
    if constexpr (!kConstantTargets) {
      last += table.terminal_tilt_taps[m] * problem.tilt_ref_rad[kHorizon - 1];
    }
    filtered[kHorizon - 1 - m] += last;
  }
}

/// The optimum without limits, u + input_offset, into `inputs`. @returns whether it keeps the limits.
/// One function for each shape of problem: in one body the compilers share work between the branches and spill.
template <typename T, std::size_t kStates, bool kConstantTargets>
__attribute__((noinline)) bool solve_unconstrained(const GainTable<T>& table, const Problem<T>& problem, T low_rad,
                                                   T high_rad, T* inputs) {
  const T origin_m = problem.position_ref_m[kHorizon - 1];
  alignas(32) T filtered[kHorizon];  // NOLINT(modernize-avoid-c-arrays): scratch
  filter_references<T, kStates, kConstantTargets>(table, problem, origin_m, filtered);

  settle(filtered);
  Column<T> sum;
  sum.set(table.state_gain.data(), problem.state[0] - origin_m);
  add_columns(sum, table.state_gain.data() + kHorizon, kHorizon, problem.state.data() + 1, kStates - 1);
  sum.add(table.disturbance_gain.data(), problem.disturbance_m_s2);
  if constexpr (kConstantTargets) {
    sum.add(table.tilt_target_gain.data(), problem.tilt_ref_rad[0]);
    sum.add(table.input_target_gain.data(), problem.input_ref_rad[0] + problem.input_offset_rad);
  }
  add_columns(sum, table.filter_gain.data(), kHorizon, filtered, kHorizon);
  sum.write(inputs);

  // Two comparisons that hold, not two that fail: a NaN must not pass for free.
  const Pack<T> low = spread(low_rad);
  const Pack<T> high = spread(high_rad);
  Mask<T> inside = (sum.pack[0] >= low) & (sum.pack[0] <= high);
  M100_UNROLL(20)
  for (std::size_t i = 1; i < kColumnPacks; ++i) {
    inside = inside & (sum.pack[i] >= low) & (sum.pack[i] <= high);
  }
  return all_of(inside);
}

}  // namespace m100::mpc::M100_LANES_NAMESPACE
