// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>

#include "firmware/mpc/columns.h"
#include "firmware/mpc/gain_table.h"

namespace m100::mpc {

/// 20 numbers, beyond whose end taps read zeros.
template <typename T>
using Padded = std::array<T, kHorizon + kPack>;

template <typename T>
inline void pad(const Column<T>& numbers, Padded<T>& padded) {
  std::copy(numbers.begin(), numbers.end(), padded.begin());
  std::fill(padded.begin() + kHorizon, padded.end(), T(0));
}

/// Adds taps times value to g_16..g_19: the terms of the terminal weight for a component `value` of r_20.
template <typename T>
inline void add_terminal(Column<T>& sum, const std::array<T, kMaxStates>& taps, T value) {
  for (std::size_t i = 0; i < kMaxStates; ++i) {
    T& end = sum[kHorizon - kMaxStates + i];
    end = taps[i] * value + end;
  }
}

/// Writes g (see GainTable) to `filtered`: sums of taps[m] * signal[j + m].
template <typename T, bool kConstantTargets>
inline void filter_references(const GainTable<T>& table, const Problem<T>& problem, T origin_m, Column<T>& filtered) {
  Padded<T> signal;
  pad(problem.position_ref_m, signal);
  for (std::size_t i = 0; i < kHorizon; ++i) {
    signal[i] -= origin_m;
  }
  scale_column(filtered, signal.data(), table.position_taps[0]);
  add_columns(filtered, signal.data() + 1, 1, table.position_taps.data() + 1, table.states - 1);
  pad(problem.velocity_ref_m_s, signal);
  add_columns(filtered, signal.data(), 1, table.velocity_taps.data(), table.states);
  add_terminal(filtered, table.terminal_velocity_taps, problem.velocity_ref_m_s[kHorizon - 1]);
  if constexpr (!kConstantTargets) {
    pad(problem.tilt_ref_slope, signal);
    add_columns(filtered, signal.data(), 1, table.tilt_taps.data(), table.states);
    add_terminal(filtered, table.terminal_tilt_taps, problem.tilt_ref_slope[kHorizon - 1]);
    pad(problem.input_ref_slope, signal);
    for (std::size_t i = 0; i < kHorizon; ++i) {
      signal[i] += problem.input_offset_slope;
    }
    add_columns(filtered, signal.data(), 1, table.input_taps.data(), table.states + 1);
  }
  filtered[0] = table.rate_weight * (problem.previous_input_slope + problem.input_offset_slope) + filtered[0];
}

/// Which data of the problem vary over the horizon. Each case has a function of its own: in one common body the
/// compilers share work between the cases and spill registers.
enum class Shape : std::uint8_t {
  kMovingTargets,      ///< reference and targets vary
  kConstantTargets,    ///< tilt and input target are constant, the reference varies
  kConstantReference,  ///< targets are constant and the reference is at rest: of its positions only the last is read
};

/// The optimum without limits, u + input_offset, into `inputs`. @returns whether it keeps the limits.
template <typename T, Shape kShape>
[[gnu::noinline]] bool solve_unconstrained(const GainTable<T>& table, const Problem<T>& problem, T low_slope,
                                           T high_slope, Column<T>& inputs) {
  const T origin_m = problem.position_ref_m[kHorizon - 1];
  Column<T> filtered;
  if constexpr (kShape != Shape::kConstantReference) {
    filter_references<T, kShape == Shape::kConstantTargets>(table, problem, origin_m, filtered);
  }
  scale_column(inputs, table.state_gain.data(), problem.state[0] - origin_m);
  add_columns(inputs, table.state_gain.data() + kHorizon, kHorizon, problem.state.data() + 1, table.states - 1);
  add_columns(inputs, table.disturbance_gain.data(), kHorizon, &problem.disturbance_m_s2, 1);
  if constexpr (kShape != Shape::kMovingTargets) {
    add_column(inputs, table.tilt_target_gain.data(), problem.tilt_ref_slope[0]);
    add_column(inputs, table.input_target_gain.data(), problem.input_ref_slope[0] + problem.input_offset_slope);
  }
  if constexpr (kShape == Shape::kConstantReference) {
    add_column(inputs, table.filter_gain.data(),
               table.rate_weight * (problem.previous_input_slope + problem.input_offset_slope));
  } else {
    add_columns(inputs, table.filter_gain.data(), kHorizon, filtered.data(), kHorizon);
  }
  return std::all_of(inputs.begin(), inputs.end(),
                     [low_slope, high_slope](T input) { return input >= low_slope && input <= high_slope; });
}

template <typename T>
inline bool solve_unconstrained(const GainTable<T>& table, const Problem<T>& problem, T low_slope, T high_slope,
                                Column<T>& inputs) {
  if (!problem.constant_targets) {
    return solve_unconstrained<T, Shape::kMovingTargets>(table, problem, low_slope, high_slope, inputs);
  }
  return problem.constant_reference
             ? solve_unconstrained<T, Shape::kConstantReference>(table, problem, low_slope, high_slope, inputs)
             : solve_unconstrained<T, Shape::kConstantTargets>(table, problem, low_slope, high_slope, inputs);
}

}  // namespace m100::mpc
