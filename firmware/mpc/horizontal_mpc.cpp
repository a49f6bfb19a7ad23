// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/mpc/horizontal_mpc.h"

#include "firmware/core/assert.h"
#include "firmware/mpc/preview_law.h"
#include "firmware/mpc/setpoint_law.h"

namespace m100::mpc {

template <typename T>
HorizontalMpc<T>::HorizontalMpc(const GainTable<T>& table, Law law) : table_(&table), law_(law) {
  M100_ASSERT(table.states == kMaxStates || table.states == kMaxStates - 1);
  M100_ASSERT(table.input_min_slope < table.input_max_slope);
  const SetpointTree<T>& tree = table.setpoint;
  M100_ASSERT(tree.nodes.empty() || tree.planes.size() == tree.nodes.size() * kNodeNumbers + 1);
  M100_ASSERT(tree.laws.size() % kLawNumbers == 0);
  reset();
}

template <typename T>
void HorizontalMpc<T>::reset() {
  start_over(*table_, tableau_);
}

template <typename T>
void HorizontalMpc<T>::solve_preview(const Problem<T>& problem, Solution<T>& solution) {
  mpc::solve_preview(*table_, tableau_, law_, problem, solution, counters_);
}

template <typename T>
void HorizontalMpc<T>::solve(const Problem<T>& problem, Solution<T>& solution) {
  if (law_ == Law::kMpc && problem.constant_reference && !table_->setpoint.nodes.empty() &&
      solve_setpoint(*table_, problem, solution.input_slope[0])) {
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
