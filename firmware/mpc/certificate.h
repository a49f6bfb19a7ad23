// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/horizontal_mpc.h"
#include "firmware/mpc/lanes.h"
#include "firmware/mpc/swept.h"

namespace m100::mpc::M100_LANES_NAMESPACE {

/// What counts as zero, in the arithmetic of T: how far an input may be outside its limit [rad] and how wrong the sign
/// of a multiplier [cost/rad] before the iteration acts, and what the certificate accepts.
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

/// What the active-set iteration ends with: the sequence that its column says, and how wrong that is by the gradient,
/// computed afresh from H instead of from the tableau that led there.
template <typename T>
class Certificate {
 public:
  /// @param column the iteration's: free inputs and multipliers. It and the other two are overwritten.
  M100_INLINE Certificate(const GainTable<T>& table, const Tableau<T>& tableau, const T* unconstrained, T low_rad,
                          T high_rad, T* column, T* pivot, T* gradient)
      : table_(table),
        tableau_(tableau),
        unconstrained_(unconstrained),
        low_rad_(low_rad),
        high_rad_(high_rad),
        column_(column),
        pivot_(pivot),
        gradient_(gradient) {}

  /// The sequence, limits met exactly, refined where T is short of digits. @returns the largest violation of the
  /// optimality conditions.
  M100_INLINE T finish(T* inputs) {
    clamp(inputs);
    const T residual = certificate(inputs);
    if (!(residual > Tolerance<T>::kRefine)) {
      return residual;
    }
    refine(inputs);
    return certificate(inputs);
  }

 private:
  /// inputs = column_ on the free inputs, held inside the limits, and the limits on the others.
  M100_INLINE void clamp(T* inputs) const {
    const Pack<T> low = spread(low_rad_);
    const Pack<T> high = spread(high_rad_);
    const Pack<T> zero = spread(T(0));
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> side = load(tableau_.side.data() + b * kLanes);
      Pack<T> value = load(column_ + b * kLanes);
      value = choose<T>(is_below<T>(value, low), low, value);
      value = choose<T>(is_below<T>(high, value), high, value);
      value = choose<T>(is_below<T>(zero, side), high, value);
      value = choose<T>(is_below<T>(side, zero), low, value);
      store<T>(inputs + b * kLanes, value);
    }
  }

  /// gradient_ = H (inputs - unconstrained). @returns its largest wrong entry; if that is not a number, no number.
  M100_INLINE T certificate(const T* inputs) {
    alignas(32) T away[kHorizon];  // NOLINT(modernize-avoid-c-arrays): scratch
    const Pack<T> zero = spread(T(0));
    Column<T> sum;
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      store<T>(away + b * kLanes, load(inputs + b * kLanes) - load(unconstrained_ + b * kLanes));
    }
    settle(away);
    sum.set(table_.hessian.data(), away[0]);
    add_columns(sum, table_.hessian.data() + kHorizon, kHorizon, away + 1, kHorizon - 1);
    sum.write(gradient_);
    // A NaN anywhere in `away` is one everywhere in the gradient, and comes through: the last pack is compared last.
    Pack<T> most = zero;
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> g = sum.pack[b];
      const Pack<T> side = load(tableau_.side.data() + b * kLanes);
      const Pack<T> size = larger<T>(g, -g);
      const Pack<T> wrong = choose<T>(is_equal<T>(side, zero), size, side * g);
      most = larger<T>(most, wrong);
    }
    return largest_of<T>(most);
  }

  /// inputs_F -= M_FF gradient_F: one Newton step on the free inputs.
  M100_INLINE void refine(T* inputs) {
    const Pack<T> zero = spread(T(0));
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Mask<T> is_free = is_equal<T>(load(tableau_.side.data() + b * kLanes), zero);
      store<T>(pivot_ + b * kLanes, choose<T>(is_free, -load(gradient_ + b * kLanes), zero));
      store<T>(column_ + b * kLanes, load(inputs + b * kLanes));
    }
    settle(pivot_);
    add_product(tableau_.swept.data(), pivot_, column_);
    clamp(inputs);
  }

  const GainTable<T>& table_;
  const Tableau<T>& tableau_;
  const T* unconstrained_;
  T low_rad_;
  T high_rad_;
  T* column_;
  T* pivot_;
  T* gradient_;
};

}  // namespace m100::mpc::M100_LANES_NAMESPACE
