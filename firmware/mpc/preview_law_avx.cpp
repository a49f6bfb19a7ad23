// SPDX-License-Identifier: BSD-3-Clause
// Both laws in double, compiled once more for x86-64 machines with 256-bit registers: the same operations in the
// same order, four to an instruction, and so the same bits.
#include "firmware/mpc/preview_law.h"
#include "firmware/mpc/setpoint_law.h"

namespace m100::mpc {

void solve_preview_avx(const GainTable<double>& table, Tableau<double>& tableau, const Problem<double>& problem,
                       Solution<double>& solution, MpcCounters& counters) {
  avx::solve_preview<double>(table, tableau, problem, solution, counters);
}

bool solve_setpoint_avx(const GainTable<double>& table, const Problem<double>& problem, double& input_rad) {
  return avx::solve_setpoint<double>(table, problem, input_rad);
}

}  // namespace m100::mpc
