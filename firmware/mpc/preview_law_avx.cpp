// SPDX-License-Identifier: BSD-3-Clause
// The preview law in double, compiled once more for x86-64 machines with 256-bit registers: the same operations in the
// same order, four to an instruction, and so the same bits.
#include "firmware/mpc/preview_law.h"

namespace m100::mpc {

void solve_preview_avx(const GainTable<double>& table, Tableau<double>& tableau, const Problem<double>& problem,
                       Solution<double>& solution, MpcCounters& counters) {
  avx::solve_preview<double>(table, tableau, problem, solution, counters);
}

}  // namespace m100::mpc
