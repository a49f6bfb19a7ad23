// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/core/sha256.h"
#include "firmware/mpc/problem.h"

namespace m100::mpc {

// Lower triangles are stored by rows, each row padded to whole packs of four: row i starts at packed_row(i) and its
// element (i, j), j <= i, is at packed_row(i) + j. The elements after the diagonal inside the last pack are never used.
inline constexpr std::size_t kPack = 4;
constexpr std::size_t packed_row(std::size_t row) {
  const std::size_t block = row / kPack;
  return kPack * (block + 1) * (2 * block + row % kPack);
}
/// Distance from the first element of a row to that of the next one.
constexpr std::size_t padded_row(std::size_t row) { return kPack * (row / kPack + 1); }
inline constexpr std::size_t kPackedSize = packed_row(kHorizon);

/// The linear model of one axis between two ticks, for the prediction through the transport delay.
///   x(t + h) = transition x + input (u + input_offset) + disturbance d, states as in Problem
template <typename T>
struct StepModel {
  std::array<T, kMaxStates * kMaxStates> transition{};  ///< row-major
  std::array<T, kMaxStates> input{};
  std::array<T, kMaxStates> disturbance{};
};

/// Relation between the measured attitude and the states of the model when the axis has a lead zero z:
///   tilt = chi + z chi', the model's states are (chi, chi').   chi' = rate_gain (tilt' - jump (u - tilt)),
///   chi = tilt - z chi'. First order: chi = (tilt - share u) / (1 - share), share = z / tau.
template <typename T>
struct LeadZero {
  T zero_s{0};  ///< 0: no zero, the states are tilt and tilt rate themselves
  T rate_gain{1};
  T jump{0};
  T share{0};
};

/// Transport delay of one axis: whole ticks, and a rest of less than a tick, which comes first.
template <typename T>
struct DelayModel {
  std::uint32_t ticks = 0;
  T delay_s{0};
  StepModel<T> rest;  ///< over delay_s - ticks * 10 ms
  StepModel<T> tick;  ///< over 10 ms
  LeadZero<T> lead;
};

inline constexpr std::size_t kSetpointStates = 8;  ///< parameters of the law, the two rests included
inline constexpr std::size_t kLawNumbers = 9;      ///< per affine law: one for each parameter, and a constant
inline constexpr std::size_t kNodePlanes = 3;      ///< per node of the tree
inline constexpr std::size_t kPlaneNumbers = 7;    ///< per plane: a constant, and one for each of z_0 to z_5
inline constexpr std::size_t kNodeNumbers = kNodePlanes * kPlaneNumbers;

/// A node with up to three planes. Bit i of the index of the child is set if z is not on the negative side of plane i.
struct SetpointNode {
  std::array<std::uint16_t, 1U << kNodePlanes> child;  ///< see SetpointTree::kLeaf
};

/// The explicit law for a constant reference: a search tree over planes, then one affine law, clipped. Parameters
///   z = (position error, velocity, tilt - target, tilt rate, previous input - steady input, steady input, rd, rs):
/// steady input = target / input_gain - input_offset; rd, rs are the differences of disturbance and input target from
/// their steady values (for example by rounding): planes ignore them, laws do not. If mirror' z is negative, z and the
/// resulting input are negated.
template <typename T>
struct SetpointTree {
  static constexpr std::uint16_t kLeaf = 0x8000;  ///< child = kLeaf + row of laws
  std::span<const SetpointNode> nodes{};          ///< empty: there is no set-point law
  std::span<const T> planes{};                    ///< per node: 3 planes' constants, factors of z_0, ...; at the end 0
  std::span<const T> laws{};                      ///< rows of kLawNumbers: u_0 before clipping
  std::array<T, kSetpointStates> box{};           ///< the law is valid for |z_i| <= box_i
  std::array<T, kPlaneNumbers - 1> mirror{};
  std::uint32_t depth = 0;  ///< most nodes on any path
};

/// All constants of one axis' controller that depend on the vehicle, computed by `m100-lab gains`. Plain data:
/// constexpr tables stay in flash. One table: about 6 KiB in float without the set-point law.
///
/// The unconstrained optimum. With positions counted from r_20, A the model's transition, q the shift by one stage,
/// 1 + sum a_i q^i = det(I - q A') and C that polynomial as a 20 x 20 upper triangular band matrix:
///   u = state_gain x + disturbance_gain d + tilt_target_gain th + input_target_gain s + filter_gain g,
///   g = taps applied to p_ref, v_ref (and th_ref, s where they are not constant) + terminal taps + Rd u_prev e_0,
/// where filter_gain = H^-1 C^-1 and g = C (S' Q r + R s + Rd u_prev e_0): the long memory of the adjoint model is in
/// C^-1, which is constant, so that any preview costs only a few taps. See decision mpc 1.
template <typename T>
struct GainTable {
  core::Sha256Digest vehicle{};  ///< of the vehicle file's text that the table was made from
  std::uint32_t states = 3;
  T input_min_slope{0};
  T input_max_slope{0};
  T tilt_sign{1};  ///< acceleration = tilt_sign * acceleration_per_tilt * tilt - drag * velocity + disturbance
  T acceleration_per_tilt{0};
  T drag_per_s{0};
  T input_gain{1};  ///< steady tilt over input

  T rate_weight{0};  ///< Rd
  std::array<T, kMaxStates> position_taps{};
  std::array<T, kMaxStates> velocity_taps{};
  std::array<T, kMaxStates> tilt_taps{};
  std::array<T, kMaxStates + 1> input_taps{};
  std::array<T, kMaxStates> terminal_velocity_taps{};  ///< of r_20's velocity, into g_16..g_19
  std::array<T, kMaxStates> terminal_tilt_taps{};
  std::array<T, kHorizon * kMaxStates> state_gain{};  ///< 20 x 4, column-major
  std::array<T, kHorizon> disturbance_gain{};
  std::array<T, kHorizon> tilt_target_gain{};
  std::array<T, kHorizon> input_target_gain{};
  std::array<T, kHorizon * kHorizon> filter_gain{};  ///< 20 x 20, column-major
  std::array<T, kHorizon * kHorizon> hessian{};      ///< 20 x 20, symmetric
  std::array<T, kPackedSize> inverse_hessian{};      ///< lower triangle, packed
  /// Effect of clipping an input on itself and the later ones: columns of L in H^-1 = L D L', L_ii = 1, each starting
  /// with the pack of its diagonal, zeros before it.
  std::array<T, kPackedSize> clipping_gain{};

  DelayModel<T> delay;
  SetpointTree<T> setpoint;
};

/// Both horizontal axes of one vehicle.
template <typename T>
struct GainTables {
  GainTable<T> x;  ///< by pitch, x'' = +g tilt
  GainTable<T> y;  ///< by roll,  y'' = -g tilt
};

}  // namespace m100::mpc
