// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/lanes.h"

namespace m100::mpc::M100_LANES_NAMESPACE {

/// Eight numbers times eight, added in one order on every machine: lanes i and i + 4 first, then lanes 0, 2 and 1, 3.
template <typename T>
M100_INLINE T dot8(const T* row, const T* z) {
#ifdef M100_LANES_SCALAR
  const T a = row[0] * z[0] + row[4] * z[4];
  const T b = row[1] * z[1] + row[5] * z[5];
  const T c = row[2] * z[2] + row[6] * z[6];
  const T d = row[3] * z[3] + row[7] * z[7];
  return (a + c) + (b + d);
#else
  const Pack<T> sum = load(row) * load(z) + load(row + kPack) * load(z + kPack);
  if constexpr (sizeof(T) == sizeof(double)) {  // the same additions, two at a time
    using Half = double __attribute__((vector_size(16)));
    const Half half = Half{sum[0], sum[1]} + Half{sum[2], sum[3]};
    return half[0] + half[1];
  }
  return (sum[0] + sum[2]) + (sum[1] + sum[3]);
#endif
}

/// The set-point law; see SetpointTree. @returns whether the problem is inside its box; then `input_rad` is u_0.
/// Cost: at most depth + 1 products of eight numbers.
template <typename T>
bool solve_setpoint(const GainTable<T>& table, const Problem<T>& problem, T& input_rad) {
  const SetpointTree<T>& tree = table.setpoint;
  const T steady = problem.input_ref_rad[0];
  alignas(32) T z[kSetpointStates];  // NOLINT(modernize-avoid-c-arrays): scratch
  z[0] = problem.state[0] - problem.position_ref_m[0];
  z[1] = problem.state[1];
  z[2] = problem.state[2] - problem.tilt_ref_rad[0];
  z[3] = table.states == kMaxStates ? problem.state[3] : T(0);
  z[5] = problem.tilt_ref_rad[0] / table.input_gain - problem.input_offset_rad;
  z[4] = problem.previous_input_rad - z[5];
  for (std::size_t i = 0; i < tree.box.size(); ++i) {
    if (!((z[i] < T(0) ? -z[i] : z[i]) <= tree.box[i])) {
      return false;
    }
  }
  z[6] = T(0);
  z[7] = T(0);
  constexpr T kLargestRest = T(2e-5);  // m/s^2 and rad: targets rounded to six decimals
  T rest_disturbance =
      problem.disturbance_m_s2 + table.tilt_sign * table.acceleration_per_tilt * problem.tilt_ref_rad[0];
  T rest_target = steady - z[5];
  if (!((rest_disturbance < T(0) ? -rest_disturbance : rest_disturbance) < kLargestRest &&
        (rest_target < T(0) ? -rest_target : rest_target) < kLargestRest)) {
    return false;  // not the steady targets of this disturbance
  }
  T sign = T(1);
  if (dot8(tree.planes.data(), z) < T(0)) {
    sign = T(-1);
    M100_UNROLL(8)
    for (std::size_t i = 0; i < 6; ++i) {
      z[i] = -z[i];
    }
    rest_disturbance = -rest_disturbance;
    rest_target = -rest_target;
  }
  z[6] = T(1);
  settle(z);
  std::uint16_t at = 0;
  for (std::uint32_t i = 0; i < tree.depth && (at & SetpointTree<T>::kLeaf) == 0; ++i) {
    const SetpointNode& node = tree.nodes[at];
    at = node.child[dot8(tree.planes.data() + node.plane * kSetpointStates, z) >= T(0) ? 1 : 0];
  }
  if ((at & SetpointTree<T>::kLeaf) == 0) {
    return false;  // a depth that does not belong to this tree
  }
  const T* law = tree.laws.data() + static_cast<std::size_t>(at - SetpointTree<T>::kLeaf) * kLawStates;
  z[7] = rest_disturbance;
  settle(z);
  const T input = sign * (dot8(law, z) + law[8] * rest_target);
  input_rad =
      input < table.input_min_rad ? table.input_min_rad : (input > table.input_max_rad ? table.input_max_rad : input);
  return true;
}

}  // namespace m100::mpc::M100_LANES_NAMESPACE
