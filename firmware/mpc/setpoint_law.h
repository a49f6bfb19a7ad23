// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/lanes.h"

namespace m100::mpc::M100_LANES_NAMESPACE {

/// Inner product of eight numbers, added in one order on every machine: i and i + 4 first, then lanes 0, 2 and 1, 3.
template <typename T>
M100_INLINE T dot8(const T* row, const T* z) {
#ifdef M100_LANES_SCALAR
  const T a = row[4] * z[4] + row[0] * z[0];
  const T b = row[5] * z[5] + row[1] * z[1];
  const T c = row[6] * z[6] + row[2] * z[2];
  const T d = row[7] * z[7] + row[3] * z[3];
  return (a + c) + (b + d);
#else
  const Pack<T> sum = load(row + kPack) * load(z + kPack) + load(row) * load(z);
  if constexpr (sizeof(T) == sizeof(double)) {  // the same additions, two at a time
    using Half = double __attribute__((vector_size(16)));
    const Half half = Half{sum[0], sum[1]} + Half{sum[2], sum[3]};
    return half[0] + half[1];
  }
  return (sum[0] + sum[2]) + (sum[1] + sum[3]);
#endif
}

/// Finds the child of a node to which z leads; the three planes are evaluated in three lanes, the fourth is unused.
template <typename T>
class NodeWalk {
 public:
  M100_INLINE explicit NodeWalk(const T* z) {
    M100_UNROLL(6)
    for (std::size_t i = 0; i < kPlaneNumbers - 1; ++i) {
      z_[i] = spread(z[i]);
    }
  }
  M100_INLINE std::size_t places(const T* planes) const {
#ifdef M100_LANES_SCALAR
    std::size_t found = 0;
    for (std::size_t plane = 0; plane < kNodePlanes; ++plane) {
      T sum = planes[plane];
      for (std::size_t i = 0; i < kPlaneNumbers - 1; ++i) {
        sum = planes[(i + 1) * kNodePlanes + plane] * z_[i] + sum;
      }
      found |= (sum >= T(0) ? 1U : 0U) << plane;
    }
    return found;
#else
    Pack<T> sum = load(planes);
    M100_UNROLL(6)
    for (std::size_t i = 0; i < kPlaneNumbers - 1; ++i) {
      sum = load(planes + (i + 1) * kNodePlanes) * z_[i] + sum;
    }
    return bits_of<T>(is_at_most<T>(spread(T(0)), sum)) & 7U;
#endif
  }

 private:
  Pack<T> z_[kPlaneNumbers - 1];  // NOLINT(modernize-avoid-c-arrays): registers
};

/// The set-point law; see SetpointTree. @returns whether the problem is inside its box and the tree is sound; then
/// `input_rad` is u_0. Cost: at most 3 depth + 1 inner products of six numbers, and one of eight.
template <typename T>
bool solve_setpoint(const GainTable<T>& table, const Problem<T>& problem, T& input_rad) {
  const SetpointTree<T>& tree = table.setpoint;
  const T steady = problem.tilt_ref_rad[0] / table.input_gain - problem.input_offset_rad;
  alignas(32) T z[kSetpointStates];  // NOLINT(modernize-avoid-c-arrays): scratch
  z[0] = problem.state[0] - problem.position_ref_m[0];
  z[1] = problem.state[1];
  z[2] = problem.state[2] - problem.tilt_ref_rad[0];
  z[3] = table.states == kMaxStates ? problem.state[3] : T(0);
  z[4] = problem.previous_input_rad - steady;
  z[5] = steady;
  z[6] = table.tilt_sign * table.acceleration_per_tilt * problem.tilt_ref_rad[0] + problem.disturbance_m_s2;
  z[7] = problem.input_ref_rad[0] - steady;
  T along = z[0] * tree.mirror[0];
  M100_UNROLL(5)
  for (std::size_t i = 1; i < kPlaneNumbers - 1; ++i) {
    along = z[i] * tree.mirror[i] + along;
  }
  const T sign = along < T(0) ? T(-1) : T(1);
  pin_in_memory(z);
  const Pack<T> mirrored = spread(sign);
  Mask<T> inside = is_equal<T>(mirrored, mirrored);
  M100_UNROLL(8)
  for (std::size_t i = 0; i < kSetpointStates; i += kLanes) {
    const Pack<T> value = load(z + i);
    store<T>(z + i, value * mirrored);
    const Pack<T> most = load(tree.box.data() + i);
    inside = inside & is_at_most<T>(value, most) & is_at_most<T>(-value, most);
  }
  if (bits_of<T>(inside) != kAllLanes) {
    return false;
  }
  pin_in_memory(z);
  const NodeWalk<T> walk(z);
  std::size_t at = 0;
  for (std::size_t before = at;; before = at) {  // ends: children come after their parents, or the law is refused
    at = tree.nodes[at].child[walk.places(tree.planes.data() + at * kNodeNumbers)];
    if (at >= SetpointTree<T>::kLeaf) {
      break;
    }
    if (at <= before) {
      return false;
    }
  }
  const T* law = tree.laws.data() + (at - SetpointTree<T>::kLeaf) * kLawNumbers;
  const T input = sign * (dot8(law, z) + law[kSetpointStates]);
  input_rad =
      input < table.input_min_rad ? table.input_min_rad : (input > table.input_max_rad ? table.input_max_rad : input);
  return true;
}

}  // namespace m100::mpc::M100_LANES_NAMESPACE
