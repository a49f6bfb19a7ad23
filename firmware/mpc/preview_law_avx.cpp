// SPDX-License-Identifier: BSD-3-Clause
// Both laws, compiled once more for x86-64 machines with 256-bit registers: the same operations in the same order, four
// to an instruction, and so the same bits.
#include "firmware/mpc/preview_law.h"
#include "firmware/mpc/setpoint_law.h"

namespace m100::mpc {

template <typename T>
void solve_preview_avx(const GainTable<T>& table, Tableau<T>& tableau, Law law, const Problem<T>& problem,
                       Solution<T>& solution, MpcCounters& counters) {
  avx::solve_preview<T>(table, tableau, law, problem, solution, counters);
}

template <typename T>
bool solve_setpoint_avx(const GainTable<T>& table, const Problem<T>& problem, T& input_rad) {
  return avx::solve_setpoint<T>(table, problem, input_rad);
}

template void solve_preview_avx(const GainTable<float>&, Tableau<float>&, Law, const Problem<float>&, Solution<float>&,
                                MpcCounters&);
template void solve_preview_avx(const GainTable<double>&, Tableau<double>&, Law, const Problem<double>&,
                                Solution<double>&, MpcCounters&);
template bool solve_setpoint_avx(const GainTable<float>&, const Problem<float>&, float&);
template bool solve_setpoint_avx(const GainTable<double>&, const Problem<double>&, double&);

}  // namespace m100::mpc
