// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/setpoint/setpoint_law.h"

#include <algorithm>

#include "firmware/core/assert.h"
#include "host_tests/lab/gains/setpoint/setpoint_packing.h"
#include "host_tests/lab/gains/setpoint/setpoint_tree.h"

namespace m100::lab::gains {

SetpointRows make_setpoint_law(const AxisQp& problem, const SetpointBox& box, ComputeBudget budget,
                               const SetpointProgress& progress) {
  SetpointRows out;
  if (problem.u_min != -problem.u_max || static_cast<double>(problem.u_max) <= box.at(5)) {
    return out;
  }
  ParametricProgram program(problem, box);
  const ConstructionContext work(budget, progress);
  try {
    const Regions regions(program, work);
    pack_planes(split_box(regions, program, work, out), out);
    out.regions = regions.all().size();
    out.pieces = static_cast<std::size_t>(std::count_if(regions.pieces().begin(), regions.pieces().end(),
                                                        [](const Piece& piece) { return piece.side == 0; }));
  } catch (const TooLarge&) {
    out = {};
    out.too_large = true;
  }
  out.box = box;
  out.programs = budget.programs_spent();
  out.comparisons = budget.comparisons_spent();
  return out;
}

void attach(const SetpointRows& rows, mpc::GainTable<double>& table) {
  M100_ASSERT(rows.nodes.empty() || rows.planes.size() == rows.nodes.size() * mpc::kNodeNumbers + 1);
  M100_ASSERT(rows.laws.size() % mpc::kLawNumbers == 0);
  table.setpoint.nodes = rows.nodes;
  table.setpoint.planes = rows.planes;
  table.setpoint.laws = rows.laws;
  table.setpoint.box = rows.box;
  table.setpoint.mirror = rows.mirror;
  table.setpoint.depth = rows.depth;
}

}  // namespace m100::lab::gains
