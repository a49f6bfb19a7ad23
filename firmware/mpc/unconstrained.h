// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/lanes.h"

namespace m100::mpc::M100_LANES_NAMESPACE {

/// 20 numbers, beyond whose end taps read zeros. `body`: the numbers; `tail`: the last kPack of them and kPack zeros.
template <typename T>
struct Signal {
  const T* body;
  const T* tail;
};
inline constexpr std::size_t kBody = kHorizon - kPack;

/// Number of states for the loops: a constant if they are unrolled, and read from the table if they stay loops, so that
/// one body serves first and second order.
template <std::size_t kStates, typename T>
M100_INLINE std::size_t states_of([[maybe_unused]] const GainTable<T>& table) {
#ifdef M100_LANES_SCALAR
  return table.states;
#else
  return kStates;
#endif
}

/// sum += taps[m] * signal[j + m] for all j, first <= m < count.
template <typename T, std::size_t kFirst>
M100_INLINE void filter(Column<T>& sum, const Signal<T>& signal, const T* taps, std::size_t count) {
#ifdef M100_LANES_SCALAR
  add_columns(sum, signal.body + kFirst, 1, taps + kFirst, count - kFirst);
#else
  M100_UNROLL(8)
  for (std::size_t m = kFirst; m < count; ++m) {
    const Pack<T> tap = spread(taps[m]);
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kBody / kLanes; ++i) {
      sum.pack[i] = load(signal.body + i * kLanes + m) * tap + sum.pack[i];
    }
    M100_UNROLL(4)
    for (std::size_t i = kBody / kLanes; i < kColumnPacks; ++i) {
      sum.pack[i] = load(signal.tail + (i * kLanes - kBody) + m) * tap + sum.pack[i];
    }
  }
#endif
}

/// Copies the last pack of 20 numbers (without vector registers: all 20) to `tail`, followed by zeros.
template <typename T>
M100_INLINE Signal<T> with_tail(const T* numbers, T* tail) {
#ifdef M100_LANES_SCALAR  // body and tail in one piece
  for (std::size_t i = 0; i < kHorizon + kPack; ++i) {
    tail[i] = i < kHorizon ? numbers[i] : T(0);
  }
  return {tail, tail + kBody};
#else
  M100_UNROLL(4)
  for (std::size_t i = 0; i < kPack; i += kLanes) {
    store<T>(tail + i, load(numbers + kBody + i));
    store<T>(tail + kPack + i, spread(T(0)));
  }
  return {numbers, tail};
#endif
}

/// Adds taps times value to g_16..g_19: the terms of the terminal weight for a component `value` of r_20.
template <typename T>
M100_INLINE void add_terminal(Column<T>& sum, const std::array<T, kMaxStates>& taps, T value) {
  static_assert(kMaxStates == kPack);
  const Pack<T> same = spread(value);
  M100_UNROLL(4)
  for (std::size_t i = kBody / kLanes; i < kColumnPacks; ++i) {
    sum.pack[i] = load(taps.data() + (i * kLanes - kBody)) * same + sum.pack[i];
  }
}

/// Writes g (see GainTable) to `filtered`.
template <typename T, std::size_t kStates, bool kConstantTargets>
M100_INLINE void filter_references(const GainTable<T>& table, const Problem<T>& problem, T origin_m, T* filtered) {
  alignas(32) T near[kHorizon + kPack];  // NOLINT(modernize-avoid-c-arrays): scratch, not initialised on purpose
  alignas(32) T tail[kHorizon + kPack];  // NOLINT(modernize-avoid-c-arrays)
  Column<T> sum;
  const Pack<T> origin = spread(origin_m);
  const Pack<T> first_tap = spread(table.position_taps[0]);
  M100_UNROLL(20)
  for (std::size_t i = 0; i < kColumnPacks; ++i) {
    const Pack<T> position = load(problem.position_ref_m.data() + i * kLanes) - origin;
    store<T>(near + i * kLanes, position);
    sum.pack[i] = position * first_tap;
  }
  M100_UNROLL(4)
  for (std::size_t i = 0; i < kPack; i += kLanes) {
    store<T>(near + kHorizon + i, spread(T(0)));
  }
  const std::size_t states = states_of<kStates>(table);
  filter<T, 1>(sum, {near, near + kBody}, table.position_taps.data(), states);
  filter<T, 0>(sum, with_tail(problem.velocity_ref_m_s.data(), tail), table.velocity_taps.data(), states);
  add_terminal(sum, table.terminal_velocity_taps, problem.velocity_ref_m_s[kHorizon - 1]);
  if constexpr (!kConstantTargets) {
    filter<T, 0>(sum, with_tail(problem.tilt_ref_rad.data(), tail), table.tilt_taps.data(), states);
    add_terminal(sum, table.terminal_tilt_taps, problem.tilt_ref_rad[kHorizon - 1]);
    const Pack<T> offset = spread(problem.input_offset_rad);
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kColumnPacks; ++i) {
      store<T>(near + i * kLanes, load(problem.input_ref_rad.data() + i * kLanes) + offset);
    }
    filter<T, 0>(sum, {near, near + kBody}, table.input_taps.data(), states + 1);
  }
  sum.write(filtered);
  filtered[0] = table.rate_weight * (problem.previous_input_rad + problem.input_offset_rad) + filtered[0];
}

/// Which data of the problem vary over the horizon. Each case has a function of its own: in one common body the
/// compilers share work between the cases and spill registers.
enum class Shape : std::uint8_t {
  kMovingTargets,      ///< reference and targets vary
  kConstantTargets,    ///< tilt and input target are constant, the reference varies
  kConstantReference,  ///< targets are constant and the reference is at rest: of its positions only the last is read
};

/// The optimum without limits, u + input_offset, into `inputs`. @returns whether it keeps the limits.
template <typename T, std::size_t kStates, Shape kShape>
__attribute__((noinline)) bool solve_unconstrained(const GainTable<T>& table, const Problem<T>& problem, T low_rad,
                                                   T high_rad, T* inputs) {
  const T origin_m = problem.position_ref_m[kHorizon - 1];
  alignas(32) T filtered[kHorizon];  // NOLINT(modernize-avoid-c-arrays): scratch
  if constexpr (kShape != Shape::kConstantReference) {
    filter_references<T, kStates, kShape == Shape::kConstantTargets>(table, problem, origin_m, filtered);
    pin_in_memory(filtered);
  }
  Column<T> sum;
  sum.set(table.state_gain.data(), problem.state[0] - origin_m);
  add_columns(sum, table.state_gain.data() + kHorizon, kHorizon, problem.state.data() + 1,
              states_of<kStates>(table) - 1);
  add_columns(sum, table.disturbance_gain.data(), kHorizon, &problem.disturbance_m_s2, 1);
  if constexpr (kShape != Shape::kMovingTargets) {
    sum.add(table.tilt_target_gain.data(), problem.tilt_ref_rad[0]);
    sum.add(table.input_target_gain.data(), problem.input_ref_rad[0] + problem.input_offset_rad);
  }
  if constexpr (kShape == Shape::kConstantReference) {
    sum.add(table.filter_gain.data(), table.rate_weight * (problem.previous_input_rad + problem.input_offset_rad));
  } else {
    add_columns(sum, table.filter_gain.data(), kHorizon, filtered, kHorizon);
  }
  sum.write(inputs);

#ifdef M100_LANES_SCALAR
  for (const T input : sum.pack) {
    if (!(input >= low_rad && input <= high_rad)) {
      return false;
    }
  }
  return true;
#else
  // A number in the problem that is not finite makes every element of the solution not finite. With a NaN, larger() and
  // smaller() return their second argument, so the NaNs of the last pack remain, and both comparisons are then false.
  Pack<T> most = sum.pack[0];
  Pack<T> least = sum.pack[0];
  M100_UNROLL(20)
  for (std::size_t i = 1; i < kColumnPacks; ++i) {
    most = larger<T>(most, sum.pack[i]);
    least = smaller<T>(least, sum.pack[i]);
  }
  return bits_of<T>(is_at_most<T>(most, spread(high_rad)) & is_at_most<T>(spread(low_rad), least)) == kAllLanes;
#endif
}

template <typename T, std::size_t kStates>
M100_INLINE bool solve_unconstrained(const GainTable<T>& table, const Problem<T>& problem, T low_rad, T high_rad,
                                     T* inputs) {
  if (!problem.constant_targets) {
    return solve_unconstrained<T, kStates, Shape::kMovingTargets>(table, problem, low_rad, high_rad, inputs);
  }
  return problem.constant_reference
             ? solve_unconstrained<T, kStates, Shape::kConstantReference>(table, problem, low_rad, high_rad, inputs)
             : solve_unconstrained<T, kStates, Shape::kConstantTargets>(table, problem, low_rad, high_rad, inputs);
}

}  // namespace m100::mpc::M100_LANES_NAMESPACE
