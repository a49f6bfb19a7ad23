// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/columns.h"
#include "firmware/mpc/horizontal_mpc.h"
#include "firmware/mpc/swept.h"

namespace m100::mpc {

/// Tolerances in the arithmetic of T. The iteration changes the active set if an input is outside its limit by more
/// than kLimit_slope, or if a multiplier has the wrong sign by more than kMultiplier [cost/slope]. The certificate
/// accepts a residual up to kCertificate; the sequence is refined if its residual exceeds kRefine [cost/slope].
template <typename T>
struct Tolerance;
template <>
struct Tolerance<double> {
  static constexpr double kLimit_slope = 1e-12;
  static constexpr double kMultiplier = 1e-10;
  static constexpr double kCertificate = 2e-8;
  static constexpr double kRefine = 1e-10;
};
template <>
struct Tolerance<float> {
  static constexpr float kLimit_slope = 1e-6F;
  static constexpr float kMultiplier = 1e-4F;
  static constexpr float kCertificate = 2e-2F;
  static constexpr float kRefine = 0.F;
};

template <typename T>
struct ActiveSetWork {
  /// The columns are not initialised: as an aggregate they would be zeroed in every solve.
  ActiveSetWork(const GainTable<T>& gain_table, Tableau<T>& kept, const Column<T>& optimum, T low, T high)
      : table(gain_table), tableau(kept), unconstrained(optimum), low_slope(low), high_slope(high) {}

  const GainTable<T>& table;
  Tableau<T>& tableau;
  const Column<T>& unconstrained;  ///< the optimum without limits
  T low_slope;
  T high_slope;
  Column<T> column;  ///< free inputs and multipliers
  Column<T> pivot;   ///< scratch, as the others
  Column<T> scaled;
  Column<T> gradient;
};

// The end of the iteration: the sequence, and its error by the gradient, which is computed from H and not from the
// tableau.

/// inputs = work.column on the free inputs, held inside the limits, and the limits on the others.
template <typename T>
inline void clamp(const ActiveSetWork<T>& work, Column<T>& inputs) {
  for (std::size_t i = 0; i < kHorizon; ++i) {
    const T side = work.tableau.side[i];
    const T value = work.column[i];
    const T free = value < work.low_slope ? work.low_slope : (value > work.high_slope ? work.high_slope : value);
    inputs[i] = side > T(0) ? work.high_slope : (side < T(0) ? work.low_slope : free);
  }
}

/// work.gradient = H (inputs - unconstrained). @returns its largest violation of the optimality conditions; NaN if any
/// entry is NaN.
template <typename T>
inline T certificate(ActiveSetWork<T>& work, const Column<T>& inputs) {
  Column<T> away;
  for (std::size_t i = 0; i < kHorizon; ++i) {
    away[i] = inputs[i] - work.unconstrained[i];
  }
  scale_column(work.gradient, work.table.hessian.data(), away[0]);
  add_columns(work.gradient, work.table.hessian.data() + kHorizon, kHorizon, away.data() + 1, kHorizon - 1);
  // A NaN anywhere in `away` makes the whole gradient NaN, and the comparison lets it through. The result is never -0.
  T most = T(0);
  for (std::size_t i = 0; i < kHorizon; ++i) {
    const T g = work.gradient[i];
    const T side = work.tableau.side[i];
    const T size = -g < g ? g : -g;
    const T wrong = side == T(0) ? size : side * g;
    most = wrong <= most ? most : wrong;
  }
  return most;
}

/// inputs_F -= M_FF gradient_F: one Newton step on the free inputs.
template <typename T>
inline void refine(ActiveSetWork<T>& work, Column<T>& inputs) {
  for (std::size_t i = 0; i < kHorizon; ++i) {
    work.pivot[i] = work.tableau.side[i] == T(0) ? -work.gradient[i] : T(0);
  }
  work.column = inputs;
  add_product(work.tableau.swept.data(), work.pivot.data(), work.column.data());
  clamp(work, inputs);
}

/// The sequence with limits met exactly, refined once if its residual exceeds kRefine. @returns the largest violation
/// of the optimality conditions.
template <typename T>
inline T finish(ActiveSetWork<T>& work, Column<T>& inputs) {
  clamp(work, inputs);
  const T residual = certificate(work, inputs);
  if (!(residual > Tolerance<T>::kRefine)) {
    return residual;
  }
  refine(work, inputs);
  return certificate(work, inputs);
}

}  // namespace m100::mpc
