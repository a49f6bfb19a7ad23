// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

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
    clamp(inputs);
    const T residual = certificate(inputs);
    if (!(residual > Tolerance<T>::kRefine)) {
      return residual;
    }
    refine(inputs);
    return certificate(inputs);
  }

  std::uint16_t changes() const { return changes_; }

 private:
  M100_INLINE T limit(std::size_t i) const { return tableau_.side[i] > T(0) ? high_rad_ : low_rad_; }

  /// inputs = column_ on the free inputs, held inside the limits, and the limits on the others.
  M100_INLINE void clamp(T* inputs) const {
    const Pack<T> low = spread(low_rad_);
    const Pack<T> high = spread(high_rad_);
    const Pack<T> zero = spread(T(0));
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> side = load(tableau_.side.data() + b * kLanes);
      Pack<T> value = load(column_ + b * kLanes);
      value = value < low ? low : value;
      value = value > high ? high : value;
      value = side > zero ? high : value;
      value = side < zero ? low : value;
      store<T>(inputs + b * kLanes, value);
    }
  }

  /// Column k of the symmetric tableau into pivot_: row k up to the diagonal, then down the rows.
  M100_INLINE void gather(std::size_t k) {
    const T* swept = tableau_.swept.data();
    const std::size_t block = k / kPack;
    const T* row = swept + packed_row(k);
    M100_UNROLL(8)
    for (std::size_t b = 0; b < kHorizon / kPack; ++b) {
      if (b <= block) {
        M100_UNROLL(4)
        for (std::size_t i = 0; i < kPack; i += kLanes) {
          store<T>(pivot_ + b * kPack + i, load(row + b * kPack + i));
        }
      } else {
        M100_UNROLL(4)
        for (std::size_t i = 0; i < kPack; ++i) {
          pivot_[b * kPack + i] = swept[packed_row(b * kPack + i) + k];
        }
      }
    }
    for (std::size_t i = k + 1; i < (block + 1) * kPack; ++i) {
      pivot_[i] = swept[packed_row(i) + k];
    }
    settle(pivot_);
  }
  /// The way back.
  M100_INLINE void scatter(std::size_t k) {
    T* swept = tableau_.swept.data();
    const std::size_t block = k / kPack;
    T* row = swept + packed_row(k);
    M100_UNROLL(8)
    for (std::size_t b = 0; b < kHorizon / kPack; ++b) {
      if (b <= block) {
        M100_UNROLL(4)
        for (std::size_t i = 0; i < kPack; i += kLanes) {
          store<T>(row + b * kPack + i, load(pivot_ + b * kPack + i));
        }
      } else {
        M100_UNROLL(4)
        for (std::size_t i = 0; i < kPack; ++i) {
          swept[packed_row(b * kPack + i) + k] = pivot_[b * kPack + i];
        }
      }
    }
    for (std::size_t i = k + 1; i < (block + 1) * kPack; ++i) {
      swept[packed_row(i) + k] = pivot_[i];
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
    const Pack<T> zero = spread(T(0));
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Mask<T> is_free = load(tableau_.side.data() + b * kLanes) == zero;
      store<T>(column_ + b * kLanes, is_free ? load(unconstrained_ + b * kLanes) : zero);
    }
    for (std::size_t a = 0; a < kHorizon; ++a) {
      if (tableau_.side[a] != T(0)) {
        gather(a);
        move_along_pivot(-(unconstrained_[a] - limit(a)));
      }
    }
  }

  /// Sweeps k in (side != 0) or out (side == 0); pivot_ holds column k.
  /// The column is written afresh instead of leaving it to the rank-one update: that would cancel its digits away.
  M100_INLINE void sweep(std::size_t k, T side) {
    T* swept = tableau_.swept.data();
    const T inverse = T(1) / pivot_[k];
    Column<T> scaled;
    scaled.set(pivot_, -inverse);
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kHorizon; ++i) {
      T* row = swept + packed_row(i);
      const T factor = pivot_[i];
      M100_UNROLL(20)
      for (std::size_t b = 0; b < i / kLanes + 1; ++b) {
        store<T>(row + b * kLanes, load(row + b * kLanes) + scaled.pack[b] * factor);
      }
    }
    scaled.set(pivot_, side != T(0) ? inverse : -inverse);
    scaled.write(pivot_);
    pivot_[k] = -inverse;
    settle(pivot_);
    scatter(k);
    tableau_.side[k] = side;
    ++changes_;
  }

  /// Drops active inputs whose multiplier pulls the wrong way, the worst first, until none is left.
  M100_INLINE bool drop_wrong() {
    while (changes_ < kMaxChanges) {
      Largest<T> most(Tolerance<T>::kMultiplier);
      M100_UNROLL(20)
      for (std::size_t b = 0; b < kColumnPacks; ++b) {
        most.consider(-load(tableau_.side.data() + b * kLanes) * load(column_ + b * kLanes), b);
      }
      const std::size_t worst = most.found();
      if (worst == kHorizon) {
        return true;
      }
      gather(worst);
      const T step = column_[worst] / pivot_[worst];
      const T released = limit(worst) - step;
      move_along_pivot(-step);
      column_[worst] = released;
      sweep(worst, T(0));
    }
    return false;
  }

  /// The free input that is farthest outside its limits; kHorizon when none is.
  M100_INLINE std::size_t most_violated() const {
    const Pack<T> low = spread(low_rad_);
    const Pack<T> high = spread(high_rad_);
    const Pack<T> zero = spread(T(0));
    Largest<T> most(Tolerance<T>::kLimit_rad);
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> value = load(column_ + b * kLanes);
      const Pack<T> above = value - high;
      const Pack<T> below = low - value;
      const Pack<T> outside = above > below ? above : below;
      const Mask<T> is_free = load(tableau_.side.data() + b * kLanes) == zero;
      most.consider(is_free ? outside : zero, b);
    }
    return most.found();
  }

  /// The active input whose multiplier reaches zero first when column_ moves by -step pivot_, before the whole step;
  /// kHorizon when none does.
  M100_INLINE std::size_t first_to_block(T step) const {
    // Shares of the step; the smallest below 1 is the largest of their negatives above -1.
    Largest<T> first(T(-1));
    const Pack<T> never = spread(T(-1));
    const Pack<T> zero = spread(T(0));
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> side = load(tableau_.side.data() + b * kLanes);
      const Pack<T> shrinks = side * load(pivot_ + b * kLanes) * step;
      const Pack<T> value = side * load(column_ + b * kLanes);
      const Mask<T> blocks = (shrinks > zero) & (value < shrinks);
      const Pack<T> divisor = blocks ? shrinks : never;  // never: a divisor that is not zero
      first.consider(blocks ? -value / divisor : never, b);
    }
    return first.found();
  }

  /// Raises the multiplier of input i until it is at its limit, dropping on the way each active input whose multiplier
  /// would change sign.
  M100_INLINE bool enter(std::size_t i) {
    const T side = column_[i] > high_rad_ ? T(1) : T(-1);
    const T target = side > T(0) ? high_rad_ : low_rad_;
    T multiplier = T(0);
    while (changes_ < kMaxChanges) {
      gather(i);
      const T full = (column_[i] - target) / pivot_[i];
      const std::size_t blocking = first_to_block(full);
      const T step = blocking == kHorizon ? full : column_[blocking] / pivot_[blocking];
      move_along_pivot(-step);
      multiplier += step;
      if (blocking == kHorizon) {
        column_[i] = multiplier;
        sweep(i, side);
        return true;
      }
      column_[blocking] = limit(blocking);
      gather(blocking);
      sweep(blocking, T(0));
    }
    return false;
  }

  /// gradient_ = H (inputs - unconstrained). @returns its largest wrong entry; not a number if any entry is not.
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
    Largest<T> most(T(0));
    Mask<T> is_number = sum.pack[0] == sum.pack[0];
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> g = sum.pack[b];
      const Pack<T> side = load(tableau_.side.data() + b * kLanes);
      const Pack<T> size = g < zero ? -g : g;
      const Pack<T> wrong = side == zero ? size : side * g;
      most.consider(wrong, b);
      is_number = is_number & (g == g);
    }
    const std::size_t worst = most.found();
    const T largest = worst == kHorizon ? T(0) : (tableau_.side[worst] < T(0) ? -gradient_[worst] : gradient_[worst]);
    return all_of(is_number) ? (largest < T(0) ? -largest : largest) : std::numeric_limits<T>::quiet_NaN();
  }

  /// inputs_F -= M_FF gradient_F: one Newton step on the free inputs.
  M100_INLINE void refine(T* inputs) {
    Column<T> sum;
    sum.read(inputs);
    sum.write(column_);
    for (std::size_t i = 0; i < kHorizon; ++i) {
      if (tableau_.side[i] == T(0)) {
        gather(i);
        move_along_pivot(-gradient_[i]);
      }
    }
    clamp(inputs);
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
