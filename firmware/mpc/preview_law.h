// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/active_set.h"
#include "firmware/mpc/unconstrained.h"

namespace m100::mpc {

/// Writes the clipped unconstrained sequence; a NaN becomes the middle of the range.
template <typename T>
inline void clip(const Column<T>& unconstrained, T low_slope, T high_slope, Column<T>& inputs) {
  for (std::size_t i = 0; i < kHorizon; ++i) {
    const T value = unconstrained[i];
    inputs[i] = value < low_slope ? low_slope : (value > high_slope ? high_slope : value);
    if (!(value == value)) {
      inputs[i] = T(0.5) * (low_slope + high_slope);
    }
  }
}

/// Solves with limits. On entry solution.input_slope holds the optimum without limits, which violates a limit or is
/// NaN.
template <typename T>
[[gnu::noinline]] void solve_constrained(const GainTable<T>& table, Tableau<T>& tableau, T low_slope, T high_slope,
                                         Solution<T>& solution, MpcCounters& counters) {
  const Column<T> unconstrained = solution.input_slope;
  ActiveSet<T> iteration(table, tableau, unconstrained, low_slope, high_slope);
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (attempt > 0) {
      start_over(table, tableau);
      ++counters.second_tries;
    }
    const bool ended = iteration.run();
    solution.changes = static_cast<std::uint16_t>(solution.changes + iteration.changes());
    if (ended) {
      solution.kkt_residual = iteration.finish(solution.input_slope);
      if (solution.kkt_residual <= Tolerance<T>::kCertificate) {
        solution.path = Path::kActiveSet;
        ++counters.active_set;
        return;
      }
    }
  }
  start_over(table, tableau);
  clip(unconstrained, low_slope, high_slope, solution.input_slope);
  solution.path = Path::kClipped;
  ++counters.clipped;
}

/// The preview law, or with Law::kLqr its solution without limits, clipped; see HorizontalMpc.
template <typename T>
void solve_preview(const GainTable<T>& table, Tableau<T>& tableau, Law law, const Problem<T>& problem,
                   Solution<T>& solution, MpcCounters& counters) {
  const T low_slope = table.input_min_slope + problem.input_offset_slope;
  const T high_slope = table.input_max_slope + problem.input_offset_slope;
  Column<T>& inputs = solution.input_slope;
  solution.path = Path::kTable;
  solution.changes = 0;
  solution.kkt_residual = T(0);
  const bool free = solve_unconstrained(table, problem, low_slope, high_slope, inputs);
  if (free) {
    ++counters.table;
  } else if (law == Law::kMpc) {
    solve_constrained(table, tableau, low_slope, high_slope, solution, counters);
  } else {
    clip(inputs, low_slope, high_slope, inputs);
    solution.path = Path::kClipped;
    ++counters.clipped;
  }
  if (problem.input_offset_slope != T(0)) {
    for (T& input : inputs) {
      input -= problem.input_offset_slope;
    }
  }
}

}  // namespace m100::mpc
