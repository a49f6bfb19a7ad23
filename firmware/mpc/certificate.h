// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/horizontal_mpc.h"
#include "firmware/mpc/lanes.h"
#include "firmware/mpc/swept.h"

namespace m100::mpc::M100_LANES_NAMESPACE {

/// Tolerances in the arithmetic of T. The iteration changes the active set if an input is outside its limit by more
/// than kLimit_rad, or if a multiplier has the wrong sign by more than kMultiplier [cost/rad]. The certificate accepts
/// a residual up to kCertificate; the sequence is refined if its residual exceeds kRefine [cost/rad].
template <typename T>
struct Tolerance;
template <>
struct Tolerance<double> {
  static constexpr double kLimit_rad = 1e-12;
  static constexpr double kMultiplier = 1e-10;
  static constexpr double kCertificate = 2e-8;
  static constexpr double kRefine = 1e-10;
};
template <>
struct Tolerance<float> {
  static constexpr float kLimit_rad = 1e-6F;
  static constexpr float kMultiplier = 1e-4F;
  static constexpr float kCertificate = 2e-2F;
  static constexpr float kRefine = 0.F;
};

template <typename T>
struct ActiveSetWork {
  /// The columns are not initialised: as an aggregate they would be zeroed in every solve.
  M100_INLINE ActiveSetWork(const GainTable<T>& gain_table, Tableau<T>& kept, const T* optimum, T low, T high)
      : table(gain_table), tableau(kept), unconstrained(optimum), low_rad(low), high_rad(high) {}

  const GainTable<T>& table;
  Tableau<T>& tableau;
  const T* unconstrained;  ///< the optimum without limits, 20 inputs
  T low_rad;
  T high_rad;
  alignas(32) T column[kHorizon];    // NOLINT(modernize-avoid-c-arrays): free inputs and multipliers
  alignas(32) T pivot[kHorizon];     // NOLINT(modernize-avoid-c-arrays): scratch, as the others
  alignas(32) T scaled[kHorizon];    // NOLINT(modernize-avoid-c-arrays)
  alignas(32) T gradient[kHorizon];  // NOLINT(modernize-avoid-c-arrays)
};

// The end of the iteration: the sequence, and its error by the gradient, which is computed from H and not from the
// tableau.

/// inputs = work.column on the free inputs, held inside the limits, and the limits on the others.
template <typename T>
M100_INLINE void clamp(const ActiveSetWork<T>& work, T* inputs) {
  const Pack<T> low = spread(work.low_rad);
  const Pack<T> high = spread(work.high_rad);
  const Pack<T> zero = spread(T(0));
  M100_UNROLL(20)
  for (std::size_t b = 0; b < kColumnPacks; ++b) {
    const Pack<T> side = load(work.tableau.side.data() + b * kLanes);
    Pack<T> value = load(work.column + b * kLanes);
    value = choose<T>(is_below<T>(value, low), low, value);
    value = choose<T>(is_below<T>(high, value), high, value);
    value = choose<T>(is_below<T>(zero, side), high, value);
    value = choose<T>(is_below<T>(side, zero), low, value);
    store<T>(inputs + b * kLanes, value);
  }
}

/// work.gradient = H (inputs - unconstrained). @returns its largest violation of the optimality conditions; NaN if any
/// entry is NaN.
template <typename T>
M100_INLINE T certificate(ActiveSetWork<T>& work, const T* inputs) {
  alignas(32) T away[kHorizon];  // NOLINT(modernize-avoid-c-arrays): scratch
  const Pack<T> zero = spread(T(0));
  Column<T> sum;
  M100_UNROLL(20)
  for (std::size_t b = 0; b < kColumnPacks; ++b) {
    store<T>(away + b * kLanes, load(inputs + b * kLanes) - load(work.unconstrained + b * kLanes));
  }
  pin_in_memory(away);
  sum.set(work.table.hessian.data(), away[0]);
  add_columns(sum, work.table.hessian.data() + kHorizon, kHorizon, away + 1, kHorizon - 1);
  sum.write(work.gradient);
  // A NaN anywhere in `away` makes the whole gradient NaN, and reaches the result: the last pack is compared last.
  Pack<T> most = zero;
  M100_UNROLL(20)
  for (std::size_t b = 0; b < kColumnPacks; ++b) {
    const Pack<T> g = sum.pack[b];
    const Pack<T> side = load(work.tableau.side.data() + b * kLanes);
    const Pack<T> size = larger<T>(g, -g);
    const Pack<T> wrong = choose<T>(is_equal<T>(side, zero), size, side * g);
    most = larger<T>(most, wrong);
  }
  return largest_of<T>(most);
}

/// inputs_F -= M_FF gradient_F: one Newton step on the free inputs.
template <typename T>
M100_INLINE void refine(ActiveSetWork<T>& work, T* inputs) {
  const Pack<T> zero = spread(T(0));
  M100_UNROLL(20)
  for (std::size_t b = 0; b < kColumnPacks; ++b) {
    const Mask<T> is_free = is_equal<T>(load(work.tableau.side.data() + b * kLanes), zero);
    store<T>(work.pivot + b * kLanes, choose<T>(is_free, -load(work.gradient + b * kLanes), zero));
    store<T>(work.column + b * kLanes, load(inputs + b * kLanes));
  }
  pin_in_memory(work.pivot);
  add_product(work.tableau.swept.data(), work.pivot, work.column);
  clamp(work, inputs);
}

/// The sequence with limits met exactly, refined once if its residual exceeds kRefine. @returns the largest violation
/// of the optimality conditions.
template <typename T>
M100_INLINE T finish(ActiveSetWork<T>& work, T* inputs) {
  clamp(work, inputs);
  const T residual = certificate(work, inputs);
  if (!(residual > Tolerance<T>::kRefine)) {
    return residual;
  }
  refine(work, inputs);
  return certificate(work, inputs);
}

}  // namespace m100::mpc::M100_LANES_NAMESPACE
