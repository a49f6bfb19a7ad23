// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/mpc/horizontal_mpc.h"

#include "firmware/core/assert.h"

#include "firmware/mpc/preview_law.h"
#include "firmware/mpc/setpoint_law.h"

namespace m100::mpc {

#ifdef M100_MPC_AVX
template <typename T>
void solve_preview_avx(const GainTable<T>& table, Tableau<T>& tableau, Law law, const Problem<T>& problem,
                       Solution<T>& solution, MpcCounters& counters);
template <typename T>
bool solve_setpoint_avx(const GainTable<T>& table, const Problem<T>& problem, T& input_rad);
#endif

namespace {

/// The copy of the laws for this machine.
template <typename T>
typename HorizontalMpc<T>::Laws laws_of_this_machine() {
#ifdef M100_MPC_AVX
  if (__builtin_cpu_supports("avx2") != 0) {
    return {.preview = &solve_preview_avx<T>, .setpoint = &solve_setpoint_avx<T>};
  }
#endif
  // A separate constant for each T: in one pool of the file, the float build would keep the laws in double, too.
  static constexpr typename HorizontalMpc<T>::Laws kLaws{.preview = &M100_LANES_NAMESPACE::solve_preview<T>,
                                                         .setpoint = &M100_LANES_NAMESPACE::solve_setpoint<T>};
  return kLaws;
}

}  // namespace

template <typename T>
HorizontalMpc<T>::HorizontalMpc(const GainTable<T>& table, Law law)
    : table_(&table), laws_(laws_of_this_machine<T>()), law_(law) {
  // A table of other sizes would be read beyond its end; one without a box would command anything.
  M100_ASSERT(table.states == kMaxStates || table.states == kMaxStates - 1);
  M100_ASSERT(table.input_min_rad < table.input_max_rad);
  const SetpointTree<T>& tree = table.setpoint;
  M100_ASSERT(tree.nodes.empty() || tree.planes.size() == tree.nodes.size() * kNodeNumbers + 1);
  M100_ASSERT(tree.laws.size() % kLawNumbers == 0);
  reset();
}

template <typename T>
void HorizontalMpc<T>::reset() {
  M100_LANES_NAMESPACE::start_over(*table_, tableau_);
}

template <typename T>
void HorizontalMpc<T>::solve_preview(const Problem<T>& problem, Solution<T>& solution) {
  laws_.preview(*table_, tableau_, law_, problem, solution, counters_);
}

template <typename T>
void HorizontalMpc<T>::solve(const Problem<T>& problem, Solution<T>& solution) {
  if (law_ == Law::kMpc && problem.constant_reference && !table_->setpoint.nodes.empty() &&
      laws_.setpoint(*table_, problem, solution.input_rad[0])) {
    solution.path = Path::kSetpoint;
    solution.changes = 0;
    solution.kkt_residual = T(0);
    ++counters_.setpoint;
    return;
  }
  solve_preview(problem, solution);
}

template class HorizontalMpc<float>;
template class HorizontalMpc<double>;

}  // namespace m100::mpc
