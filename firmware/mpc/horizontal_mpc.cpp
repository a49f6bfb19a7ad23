// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/mpc/horizontal_mpc.h"

#include <type_traits>

#include "firmware/core/assert.h"

#include "firmware/mpc/preview_law.h"

namespace m100::mpc {

#ifdef M100_MPC_AVX
void solve_preview_avx(const GainTable<double>& table, Tableau<double>& tableau, const Problem<double>& problem,
                       Solution<double>& solution, MpcCounters& counters);
#endif

namespace {

/// Which copy of the preview law this machine runs.
template <typename T>
typename HorizontalMpc<T>::PreviewLaw preview_law() {
#ifdef M100_MPC_AVX
  if constexpr (std::is_same_v<T, double>) {
    if (__builtin_cpu_supports("avx") != 0) {
      return &solve_preview_avx;
    }
  }
#endif
  return &M100_LANES_NAMESPACE::solve_preview<T>;
}

}  // namespace

template <typename T>
HorizontalMpc<T>::HorizontalMpc(const GainTable<T>& table) : table_(&table), preview_law_(preview_law<T>()) {
  M100_ASSERT(table.states == kMaxStates || table.states == kMaxStates - 1);
  reset();
}

template <typename T>
void HorizontalMpc<T>::reset() {
  M100_LANES_NAMESPACE::start_over(*table_, tableau_);
}

template <typename T>
void HorizontalMpc<T>::solve_preview(const Problem<T>& problem, Solution<T>& solution) {
  preview_law_(*table_, tableau_, problem, solution, counters_);
}

template <typename T>
void HorizontalMpc<T>::solve(const Problem<T>& problem, Solution<T>& solution) {
  solve_preview(problem, solution);
}

template class HorizontalMpc<float>;
template class HorizontalMpc<double>;

}  // namespace m100::mpc
