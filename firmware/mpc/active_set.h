// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/certificate.h"
#include "firmware/mpc/clipping_guess.h"
#include "firmware/mpc/columns.h"
#include "firmware/mpc/horizontal_mpc.h"
#include "firmware/mpc/swept.h"

namespace m100::mpc {

/// With at least this many wrong inputs, guess_by_clipping() is nearer to the optimal active set than the kept one is.
inline constexpr int kStale = 7;

/// Dual active-set iteration for  min 1/2 (u - uu)' H (u - uu), low <= u <= high  on the swept tableau
///   M = principal pivot transform of H^-1 on the active set A:  M_FF = Schur complement, M_FA = W_FA W_AA^-1,
///   M_AA = -W_AA^-1  (W = H^-1).
/// With e_A = uu_A - limit_A: free inputs u_F = uu_F - M_FA e_A, multipliers l_A = -M_AA e_A; both live in one column
/// t. The multiplier of an upper limit is >= 0, of a lower limit <= 0.
template <typename T>
class ActiveSet {
 public:
  ActiveSet(const GainTable<T>& table, Tableau<T>& tableau, const Column<T>& unconstrained, T low_slope, T high_slope)
      : work_(table, tableau, unconstrained, low_slope, high_slope) {}

  /// One try. @returns whether the iteration ended by itself; false: it was stopped at kMaxChanges.
  bool run() {
    changes_ = 0;
    evaluate();
    const std::uint32_t wrong = wrong_places();
    if (wrong == 0) {
      return true;
    }
    if (__builtin_popcount(wrong) >= kStale) {
      adopt(guess_by_clipping(work_.table, work_.unconstrained, work_.low_slope, work_.high_slope, work_.column,
                              work_.pivot));
      evaluate();
    }
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

  /// Writes the sequence to `inputs`; it meets the limits exactly. @returns the largest violation of the optimality
  /// conditions.
  T finish(Column<T>& inputs) { return mpc::finish(work_, inputs); }

  std::uint16_t changes() const { return changes_; }

 private:
  T limit(std::size_t i) const { return work_.tableau.side[i] > T(0) ? work_.high_slope : work_.low_slope; }

  /// Computes t (work_.column) from the tableau and the sides.
  void evaluate() {
    for (std::size_t i = 0; i < kHorizon; ++i) {
      const bool is_free = work_.tableau.side[i] == T(0);
      const T optimum = work_.unconstrained[i];
      work_.column[i] = is_free ? optimum + T(0) : T(0);  // the sum is never -0, as add_product() requires
      work_.pivot[i] = is_free ? T(0) : limit(i) - optimum;
    }
    add_product(swept(), work_.pivot.data(), work_.column.data());
  }

  /// Moves input k into the active set (side != 0) or out of it (side == 0); work_.pivot holds column k. The column
  /// itself is computed from zeros, because an update would lose digits by cancellation. Not inlined: at every place
  /// that changes the set it would cost five kilobytes of flash.
  [[gnu::noinline]] void sweep(std::size_t k, T side) {
    const T inverse = T(1) / work_.pivot[k];
    const T sign = side != T(0) ? inverse : -inverse;
    scale_column(work_.scaled, work_.pivot.data(), -inverse);
    work_.scaled[k] = sign;
    clear_below(swept(), k);
    add_outer_product(swept(), work_.scaled.data(), work_.pivot.data());
    T* row = swept() + packed_row(k);
    for (std::size_t j = 0; j < k; ++j) {
      row[j] = work_.pivot[j] * sign;
    }
    row[k] = -inverse;
    work_.tableau.side[k] = side;
    ++changes_;
  }

  /// One bit for each input that is free and outside its limits, or active with a multiplier of the wrong sign.
  std::uint32_t wrong_places() const {
    const T low_slope = work_.low_slope - Tolerance<T>::kLimit_slope;
    const T high_slope = work_.high_slope + Tolerance<T>::kLimit_slope;
    std::uint32_t places = 0;
    for (std::size_t i = 0; i < kHorizon; ++i) {
      const T side = work_.tableau.side[i];
      const T value = work_.column[i];
      const bool is_wrong =
          side == T(0) ? value < low_slope || value > high_slope : side * value < -Tolerance<T>::kMultiplier;
      places |= (is_wrong ? 1U : 0U) << i;
    }
    return places;
  }

  /// Makes the guess the active set, starting from the nearest of the kept one, the empty one and the full one (whose
  /// tableau is -H). Inputs that only change their side cost nothing.
  void adopt(std::uint32_t active) {
    constexpr std::uint32_t kAll = (1U << kHorizon) - 1;
    const Column<T> side = work_.pivot;
    std::uint32_t kept = 0;
    for (std::size_t i = 0; i < kHorizon; ++i) {
      kept |= (work_.tableau.side[i] != T(0) ? 1U : 0U) << i;
    }
    const int from_kept = __builtin_popcount(kept ^ active);
    const int from_empty = __builtin_popcount(active);
    const int from_full = static_cast<int>(kHorizon) - from_empty;
    if (from_kept > from_empty && from_empty <= from_full) {
      start_over(work_.table, work_.tableau);
      kept = 0;
    } else if (from_kept > from_full) {
      start_full(work_.table, work_.tableau);
      kept = kAll;
    }
    work_.tableau.side = side;
    for (std::uint32_t places = kept ^ active; places != 0; places &= places - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(places));
      gather(swept(), i, work_.pivot.data());
      sweep(i, side[i]);
    }
  }

  /// Drops active inputs whose multiplier has the wrong sign, the worst first. @returns false: stopped at kMaxChanges.
  bool drop_wrong() {
    while (changes_ < kMaxChanges) {
      std::size_t worst = kHorizon;
      T most = Tolerance<T>::kMultiplier;
      for (std::size_t i = 0; i < kHorizon; ++i) {
        const T pull = -work_.tableau.side[i] * work_.column[i];
        if (pull > most) {
          most = pull;
          worst = i;
        }
      }
      if (worst == kHorizon) {
        return true;
      }
      gather(swept(), worst, work_.pivot.data());
      const T step = work_.column[worst] / work_.pivot[worst];
      const T released = limit(worst) - step;
      add_column(work_.column, work_.pivot.data(), -step);
      work_.column[worst] = released;
      sweep(worst, T(0));
    }
    return false;
  }

  /// The free input that is farthest outside its limits; kHorizon when none is.
  std::size_t most_violated() const {
    std::size_t worst = kHorizon;
    T most = Tolerance<T>::kLimit_slope;
    for (std::size_t i = 0; i < kHorizon; ++i) {
      const T above = work_.column[i] - work_.high_slope;
      const T below = work_.low_slope - work_.column[i];
      const T outside = below < above ? above : below;
      if (outside > most && work_.tableau.side[i] == T(0)) {
        most = outside;
        worst = i;
      }
    }
    return worst;
  }

  /// The active input whose multiplier reaches zero first when work_.column moves by -step work_.pivot, before the
  /// whole step; kHorizon when none does.
  std::size_t first_to_block(T step) const {
    std::size_t first = kHorizon;
    T smallest = T(1);  // share of the step
    for (std::size_t i = 0; i < kHorizon; ++i) {
      const T side = work_.tableau.side[i];
      const T shrinks = side * work_.pivot[i] * step;
      if (shrinks > T(0) && side * work_.column[i] < shrinks) {
        const T share = work_.column[i] / (work_.pivot[i] * step);
        if (share < smallest) {
          smallest = share;
          first = i;
        }
      }
    }
    return first;
  }

  /// Raises the multiplier of input i until the input is at its limit, dropping each active input whose multiplier
  /// would change sign. @returns false: stopped at kMaxChanges.
  bool enter(std::size_t i) {
    const T side = work_.column[i] > work_.high_slope ? T(1) : T(-1);
    const T target = side > T(0) ? work_.high_slope : work_.low_slope;
    T multiplier = T(0);
    while (changes_ < kMaxChanges) {
      gather(swept(), i, work_.pivot.data());
      const T full = (work_.column[i] - target) / work_.pivot[i];
      const std::size_t blocking = first_to_block(full);
      const T step = blocking == kHorizon ? full : work_.column[blocking] / work_.pivot[blocking];
      add_column(work_.column, work_.pivot.data(), -step);
      multiplier += step;
      if (blocking == kHorizon) {
        work_.column[i] = multiplier;
        sweep(i, side);
        return true;
      }
      work_.column[blocking] = limit(blocking);
      gather(swept(), blocking, work_.pivot.data());
      sweep(blocking, T(0));
    }
    return false;
  }

  T* swept() { return work_.tableau.swept.data(); }

  ActiveSetWork<T> work_;
  std::uint16_t changes_ = 0;
};

}  // namespace m100::mpc
