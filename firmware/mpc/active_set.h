// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/horizontal_mpc.h"
#include "firmware/mpc/lanes.h"

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

/// Dual active-set iteration for  min 1/2 (u - uu)' H (u - uu), low <= u <= high  on the swept tableau
///   M = principal pivot transform of H^-1 on the active set A:  M_FF = Schur complement, M_FA = W_FA W_AA^-1,
///   M_AA = -W_AA^-1  (W = H^-1).
/// With e_A = uu_A - limit_A: free inputs u_F = uu_F - M_FA e_A, multipliers l_A = -M_AA e_A; both live in one column
/// t. The multiplier of an upper limit is >= 0, of a lower limit <= 0.
template <typename T>
class ActiveSet {
 public:
  M100_INLINE ActiveSet(const GainTable<T>& table, Tableau<T>& tableau, const T* unconstrained, T low_rad, T high_rad)
      : table_(table), tableau_(tableau), unconstrained_(unconstrained), low_rad_(low_rad), high_rad_(high_rad) {}

  /// One try. @returns whether the iteration ended by itself; false at the cap.
  M100_INLINE bool run() {
    changes_ = 0;
    evaluate();
    if (!drop_wrong()) {
      return false;
    }
    for (;;) {  // ends: every pass changes the active set or returns, and run() stops at kMaxChanges
      const std::size_t worst = most_violated();
      if (worst == kHorizon) {
        return true;
      }
      if (!enter(worst)) {
        return false;
      }
    }
  }

  /// The sequence, limits met exactly, refined where T is short of digits. @returns the largest violation of the
  /// optimality conditions.
  M100_INLINE T finish(T* inputs) {
    for (std::size_t i = 0; i < kHorizon; ++i) {
      inputs[i] = clamped(i, column_[i]);
    }
    const T residual = certificate(inputs);
    if (!(residual > Tolerance<T>::kRefine)) {
      return residual;
    }
    refine(inputs);
    return certificate(inputs);
  }

  std::uint16_t changes() const { return changes_; }

 private:
  M100_INLINE T limit(std::size_t i) const { return tableau_.side[i] > 0 ? high_rad_ : low_rad_; }
  M100_INLINE T clamped(std::size_t i, T free_value) const {
    if (tableau_.side[i] != 0) {
      return limit(i);
    }
    return free_value < low_rad_ ? low_rad_ : (free_value > high_rad_ ? high_rad_ : free_value);
  }

  /// Column k of the symmetric tableau into pivot_.
  M100_INLINE void gather(std::size_t k) {
    const T* swept = tableau_.swept.data();
    const std::size_t row = packed_row(k);
    const std::size_t end = k / kLanes + 1;
    for (std::size_t b = 0; b < end; ++b) {
      store<T>(pivot_ + b * kLanes, load(swept + row + b * kLanes));
    }
    for (std::size_t i = k + 1; i < kHorizon; ++i) {
      pivot_[i] = swept[packed_row(i) + k];
    }
  }

  /// column_ += pivot_ * factor
  M100_INLINE void move_along_pivot(T factor) {
    Column<T> sum;
    sum.read(column_);
    sum.add(pivot_, factor);
    sum.write(column_);
  }

  /// t from the tableau as it is.
  M100_INLINE void evaluate() {
    Column<T> sum;
    sum.read(unconstrained_);
    sum.write(column_);
    for (std::size_t a = 0; a < kHorizon; ++a) {
      if (tableau_.side[a] != 0) {
        column_[a] = T(0);
      }
    }
    for (std::size_t a = 0; a < kHorizon; ++a) {
      if (tableau_.side[a] != 0) {
        gather(a);
        move_along_pivot(-(unconstrained_[a] - limit(a)));
      }
    }
  }

  /// Sweeps k in (side != 0) or out (side == 0); pivot_ holds column k.
  /// The column is written afresh instead of leaving it to the rank-one update: that would cancel its digits away.
  M100_INLINE void sweep(std::size_t k, std::int8_t side) {
    T* swept = tableau_.swept.data();
    const T inverse = T(1) / pivot_[k];
    Column<T> scaled;
    scaled.set(pivot_, -inverse);
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kHorizon; ++i) {
      const std::size_t row = packed_row(i);
      const T factor = pivot_[i];
      M100_UNROLL(20)
      for (std::size_t b = 0; b < i / kLanes + 1; ++b) {
        store<T>(swept + row + b * kLanes, load(swept + row + b * kLanes) + scaled.pack[b] * factor);
      }
    }
    const T sign = side != 0 ? inverse : -inverse;
    scaled.set(pivot_, sign);
    scaled.write(pivot_);
    pivot_[k] = -inverse;
    const std::size_t row = packed_row(k);
    const std::size_t end = k / kLanes + 1;
    for (std::size_t b = 0; b < end; ++b) {
      store<T>(swept + row + b * kLanes, load(pivot_ + b * kLanes));
    }
    for (std::size_t i = k + 1; i < kHorizon; ++i) {
      swept[packed_row(i) + k] = pivot_[i];
    }
    tableau_.side[k] = side;
    ++changes_;
  }

  /// Drops active inputs whose multiplier pulls the wrong way, the worst first, until none is left.
  M100_INLINE bool drop_wrong() {
    while (changes_ < kMaxChanges) {
      std::size_t worst = kHorizon;
      T most = Tolerance<T>::kMultiplier;
      for (std::size_t i = 0; i < kHorizon; ++i) {
        const T wrong = -T(tableau_.side[i]) * column_[i];
        if (wrong > most) {
          most = wrong;
          worst = i;
        }
      }
      if (worst == kHorizon) {
        return true;
      }
      gather(worst);
      const T step = column_[worst] / pivot_[worst];
      const T released = limit(worst) - step;
      move_along_pivot(-step);
      column_[worst] = released;
      sweep(worst, 0);
    }
    return false;
  }

  /// The free input that is farthest outside its limits; kHorizon when none is.
  M100_INLINE std::size_t most_violated() const {
    std::size_t worst = kHorizon;
    T most = Tolerance<T>::kLimit_rad;
    for (std::size_t i = 0; i < kHorizon; ++i) {
      const T above = column_[i] - high_rad_;
      const T below = low_rad_ - column_[i];
      const T outside = above > below ? above : below;
      if (tableau_.side[i] == 0 && outside > most) {
        most = outside;
        worst = i;
      }
    }
    return worst;
  }

  /// Raises the multiplier of input i until it is at its limit, dropping on the way each active input whose multiplier
  /// would change sign.
  M100_INLINE bool enter(std::size_t i) {
    const std::int8_t side = column_[i] > high_rad_ ? std::int8_t(1) : std::int8_t(-1);
    const T target = side > 0 ? high_rad_ : low_rad_;
    T multiplier = T(0);
    while (changes_ < kMaxChanges) {
      gather(i);
      const T full = (column_[i] - target) / pivot_[i];
      T step = full;
      std::size_t blocking = kHorizon;
      for (std::size_t j = 0; j < kHorizon; ++j) {
        // l_j(step) = l_j - M_ji step; it blocks when it shrinks and reaches zero before the full step.
        const T sign = T(tableau_.side[j]);
        if (sign * column_[j] < sign * pivot_[j] * step) {
          step = column_[j] / pivot_[j];
          blocking = j;
        }
      }
      move_along_pivot(-step);
      multiplier += step;
      if (blocking == kHorizon) {
        column_[i] = multiplier;
        sweep(i, side);
        return true;
      }
      column_[blocking] = limit(blocking);
      gather(blocking);
      sweep(blocking, 0);
    }
    return false;
  }

  /// gradient_ = H (inputs - unconstrained). @returns its largest wrong entry.
  M100_INLINE T certificate(const T* inputs) {
    Column<T> sum;
    sum.set(table_.hessian.data(), inputs[0] - unconstrained_[0]);
    M100_UNROLL(20)
    for (std::size_t i = 1; i < kHorizon; ++i) {
      sum.add(table_.hessian.data() + i * kHorizon, inputs[i] - unconstrained_[i]);
    }
    sum.write(gradient_);
    T worst = T(0);
    for (std::size_t i = 0; i < kHorizon; ++i) {
      const T g = gradient_[i];
      const std::int8_t side = tableau_.side[i];
      const T wrong = side > 0 ? g : (side < 0 ? -g : (g < T(0) ? -g : g));
      worst = wrong > worst || !(wrong == wrong) ? wrong : worst;  // a NaN is the worst of all and stays
    }
    return worst;
  }

  /// inputs_F -= M_FF gradient_F: one Newton step on the free inputs.
  M100_INLINE void refine(T* inputs) {
    Column<T> sum;
    sum.read(inputs);
    sum.write(column_);
    for (std::size_t i = 0; i < kHorizon; ++i) {
      if (tableau_.side[i] == 0) {
        gather(i);
        move_along_pivot(-gradient_[i]);
      }
    }
    for (std::size_t i = 0; i < kHorizon; ++i) {
      inputs[i] = clamped(i, column_[i]);
    }
  }

  const GainTable<T>& table_;
  Tableau<T>& tableau_;
  const T* unconstrained_;
  T low_rad_;
  T high_rad_;
  std::uint16_t changes_ = 0;
  alignas(32) T column_[kHorizon];    // NOLINT(modernize-avoid-c-arrays): scratch
  alignas(32) T pivot_[kHorizon];     // NOLINT(modernize-avoid-c-arrays)
  alignas(32) T gradient_[kHorizon];  // NOLINT(modernize-avoid-c-arrays)
};

}  // namespace m100::mpc::M100_LANES_NAMESPACE
