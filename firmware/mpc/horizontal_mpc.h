// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/mpc/gain_table.h"
#include "firmware/mpc/law.h"
#include "firmware/mpc/problem.h"

namespace m100::mpc {

/// State of the preview law from tick to tick: the tableau of the active-set iteration.
template <typename T>
struct Tableau {
  std::array<T, kPackedSize> swept;  ///< principal pivot transform of H^-1 for the active set, lower triangle
  std::array<T, kHorizon> side;      ///< +1 at the upper limit, -1 at the lower, 0 free
};

/// How often each path gave the solution since the start, and how often the active set was tried again. They wrap.
struct MpcCounters {
  std::uint32_t setpoint = 0;
  std::uint32_t table = 0;
  std::uint32_t active_set = 0;
  std::uint32_t clipped = 0;
  std::uint32_t second_tries = 0;
};

/// Model predictive control of one horizontal axis (paper, III-E.1 and Eq. 2), exact, from tables.
///
///   minimise sum_k |x_k - r_k|^2_Q + R (u_k - s_k)^2 + Rd (u_k - u_{k-1})^2 + |x_20 - r_20|^2_P
///   subject to u_min <= u_k <= u_max
///
/// The set-point law solves problems with a constant reference inside the table's box: a search tree, first input only.
/// The preview law solves all others: one table product and, if limits bind, a dual active-set iteration. The
/// optimality conditions certify its result. If that fails, a second try starts from the empty active set; if both
/// fail, the clipped sequence is returned as Path::kClipped. Law::kLqr is the baseline: the table product, clipped. T
/// is float or double; the same bits on every machine. Cost and memory: README.md.
template <typename T>
class HorizontalMpc {
 public:
  /// The table must outlive the controller. It must have 3 or 4 states and input_min_slope < input_max_slope. If it has
  /// a set-point law, `planes` must hold kNodeNumbers numbers per node and one number more, and `laws` whole rows.
  explicit HorizontalMpc(const GainTable<T>& table, Law law = Law::kMpc);

  /// Solves by the set-point law where it is valid, otherwise by the preview law. Data that are not finite: kClipped.
  void solve(const Problem<T>& problem, Solution<T>& solution);
  Solution<T> solve(const Problem<T>& problem) {
    Solution<T> solution;
    solve(problem, solution);
    return solution;
  }
  /// The preview law only: the whole sequence.
  void solve_preview(const Problem<T>& problem, Solution<T>& solution);

  /// Forgets the active set of the last tick.
  void reset();

  const GainTable<T>& table() const { return *table_; }
  const MpcCounters& counters() const { return counters_; }

 private:
  const GainTable<T>* table_;
  Law law_;
  Tableau<T> tableau_;
  MpcCounters counters_;
};

extern template class HorizontalMpc<float>;
extern template class HorizontalMpc<double>;

}  // namespace m100::mpc
