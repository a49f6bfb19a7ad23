// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/gain_table.h"

namespace m100::mpc {

/// Inner product of eight numbers, added in one order on every machine: i and i + 4 first, then 0, 2 and 1, 3 of them.
template <typename T>
inline T dot8(const T* row, const T* z) {
  const T a = row[4] * z[4] + row[0] * z[0];
  const T b = row[5] * z[5] + row[1] * z[1];
  const T c = row[6] * z[6] + row[2] * z[2];
  const T d = row[7] * z[7] + row[3] * z[3];
  return (a + c) + (b + d);
}

/// The index of the child of a node to which z leads: one bit for each of its planes.
template <typename T>
inline std::size_t child_of(const T* planes, const T* z) {
  std::size_t child = 0;
  for (std::size_t plane = 0; plane < kNodePlanes; ++plane) {
    T sum = planes[plane];
    for (std::size_t i = 0; i < kPlaneNumbers - 1; ++i) {
      sum = planes[(i + 1) * kNodePlanes + plane] * z[i] + sum;
    }
    child |= (sum >= T(0) ? 1U : 0U) << plane;
  }
  return child;
}

/// The set-point law; see SetpointTree. @returns whether the problem is inside its box and the tree is sound; then
/// `input_slope` is u_0. Cost: at most 3 depth + 1 inner products of six numbers, and one of eight.
template <typename T>
bool solve_setpoint(const GainTable<T>& table, const Problem<T>& problem, T& input_slope) {
  const SetpointTree<T>& tree = table.setpoint;
  const T steady = problem.tilt_ref_slope[0] / table.input_gain - problem.input_offset_slope;
  std::array<T, kSetpointStates> z;
  z[0] = problem.state[0] - problem.position_ref_m[0];
  z[1] = problem.state[1];
  z[2] = problem.state[2] - problem.tilt_ref_slope[0];
  z[3] = table.states == kMaxStates ? problem.state[3] : T(0);
  z[4] = problem.previous_input_slope - steady;
  z[5] = steady;
  z[6] = table.tilt_sign * table.acceleration_per_tilt * problem.tilt_ref_slope[0] + problem.disturbance_m_s2;
  z[7] = problem.input_ref_slope[0] - steady;
  T along = z[0] * tree.mirror[0];
  for (std::size_t i = 1; i < kPlaneNumbers - 1; ++i) {
    along = z[i] * tree.mirror[i] + along;
  }
  const T sign = along < T(0) ? T(-1) : T(1);
  bool is_inside = true;
  for (std::size_t i = 0; i < kSetpointStates; ++i) {
    is_inside = is_inside && z[i] <= tree.box[i] && -z[i] <= tree.box[i];
    z[i] *= sign;
  }
  if (!is_inside) {
    return false;
  }
  std::size_t at = 0;
  for (std::size_t before = at;; before = at) {  // ends: children come after their parents, or the law is refused
    at = tree.nodes[at].child[child_of(tree.planes.data() + at * kNodeNumbers, z.data())];
    if (at >= SetpointTree<T>::kLeaf) {
      break;
    }
    if (at <= before) {
      return false;
    }
  }
  const T* law = tree.laws.data() + (at - SetpointTree<T>::kLeaf) * kLawNumbers;
  const T input = sign * (dot8(law, z.data()) + law[kSetpointStates]);
  input_slope = input < table.input_min_slope ? table.input_min_slope
                                              : (input > table.input_max_slope ? table.input_max_slope : input);
  return true;
}

}  // namespace m100::mpc
