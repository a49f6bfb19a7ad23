// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/certificate.h"
#include "firmware/mpc/clipping_guess.h"
#include "firmware/mpc/horizontal_mpc.h"
#include "firmware/mpc/lanes.h"
#include "firmware/mpc/swept.h"

namespace m100::mpc::M100_LANES_NAMESPACE {

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
  M100_INLINE ActiveSet(const GainTable<T>& table, Tableau<T>& tableau, const T* unconstrained, T low_rad, T high_rad)
      : work_(table, tableau, unconstrained, low_rad, high_rad) {}

  /// One try. @returns whether the iteration ended by itself; false: it was stopped at kMaxChanges.
  M100_INLINE bool run() {
    changes_ = 0;
    evaluate();
    const std::uint32_t wrong = wrong_places();
    if (wrong == 0) {
      return true;
    }
    if (__builtin_popcount(wrong) >= kStale) {
      adopt(guess_by_clipping(work_.table, work_.unconstrained, work_.low_rad, work_.high_rad, work_.column,
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
  M100_INLINE T finish(T* inputs) { return M100_LANES_NAMESPACE::finish(work_, inputs); }

  std::uint16_t changes() const { return changes_; }

 private:
  M100_INLINE T limit(std::size_t i) const { return work_.tableau.side[i] > T(0) ? work_.high_rad : work_.low_rad; }

  /// Computes t (work_.column) from the tableau and the sides.
  M100_INLINE void evaluate() {
    const Pack<T> zero = spread(T(0));
    const Pack<T> low = spread(work_.low_rad);
    const Pack<T> high = spread(work_.high_rad);
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> side = load(work_.tableau.side.data() + b * kLanes);
      const Pack<T> optimum = load(work_.unconstrained + b * kLanes);
      const Mask<T> is_free = is_equal<T>(side, zero);
      const Pack<T> away = choose<T>(is_below<T>(zero, side), high, low) - optimum;
      store<T>(work_.column + b * kLanes, choose<T>(is_free, optimum + zero, zero));
      store<T>(work_.pivot + b * kLanes, choose<T>(is_free, zero, away));
    }
    pin_in_memory(work_.pivot);
    add_product(swept(), work_.pivot, work_.column);
  }

  /// Moves input k into the active set (side != 0) or out of it (side == 0); work_.pivot holds column k. The column
  /// itself is computed from zeros, because an update would lose digits by cancellation.
  M100_INLINE_PACKS void sweep(std::size_t k, T side) {
    const T inverse = T(1) / work_.pivot[k];
    const T sign = side != T(0) ? inverse : -inverse;
    scale_column(work_.scaled, work_.pivot, -inverse);
    work_.scaled[k] = sign;
    clear_below(swept(), k);
    pin_in_memory(work_.scaled);
    add_outer_product(swept(), work_.scaled, work_.pivot);
    T* row = swept() + packed_row(k);
    const Pack<T> same = spread(sign);
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      if (b > k / kLanes) {
        break;
      }
      store<T>(row + b * kLanes, load(work_.pivot + b * kLanes) * same);
    }
    row[k] = -inverse;
    work_.tableau.side[k] = side;
    ++changes_;
  }

  /// One bit for each input that is free and outside its limits, or active with a multiplier of the wrong sign.
  M100_INLINE std::uint32_t wrong_places() const {
    const Pack<T> low = spread(work_.low_rad - Tolerance<T>::kLimit_rad);
    const Pack<T> high = spread(work_.high_rad + Tolerance<T>::kLimit_rad);
    const Pack<T> zero = spread(T(0));
    const Pack<T> pulls = spread(-Tolerance<T>::kMultiplier);
    std::uint32_t places = 0;
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> side = load(work_.tableau.side.data() + b * kLanes);
      const Pack<T> value = load(work_.column + b * kLanes);
      const Mask<T> outside = is_below<T>(value, low) | is_below<T>(high, value);
      const Mask<T> wrong = is_below<T>(side * value, pulls) | (is_equal<T>(side, zero) & outside);
      places |= bits_of<T>(wrong) << (b * kLanes);
    }
    return places;
  }

  /// Makes the guess the active set, starting from the nearest of the kept one, the empty one and the full one (whose
  /// tableau is -H). Inputs that only change their side cost nothing.
  M100_INLINE void adopt(std::uint32_t active) {
    constexpr std::uint32_t kAll = (1U << kHorizon) - 1;
    alignas(32) T side[kHorizon];  // NOLINT(modernize-avoid-c-arrays): scratch
    Column<T> sides;
    sides.read(work_.pivot);
    sides.write(side);
    std::uint32_t kept = 0;
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Mask<T> is_free = is_equal<T>(load(work_.tableau.side.data() + b * kLanes), spread(T(0)));
      kept |= (bits_of<T>(is_free) ^ kAllLanes) << (b * kLanes);
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
    sides.write(work_.tableau.side.data());
    for (std::uint32_t places = kept ^ active; places != 0; places &= places - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(places));
      gather(swept(), i, work_.pivot);
      sweep(i, side[i]);
    }
  }

  /// Drops active inputs whose multiplier has the wrong sign, the worst first. @returns false: stopped at kMaxChanges.
  M100_INLINE bool drop_wrong() {
    while (changes_ < kMaxChanges) {
      Largest<T> most(Tolerance<T>::kMultiplier);
      M100_UNROLL(20)
      for (std::size_t b = 0; b < kColumnPacks; ++b) {
        most.consider(-load(work_.tableau.side.data() + b * kLanes) * load(work_.column + b * kLanes), b);
      }
      const std::size_t worst = most.found();
      if (worst == kHorizon) {
        return true;
      }
      gather(swept(), worst, work_.pivot);
      const T step = work_.column[worst] / work_.pivot[worst];
      const T released = limit(worst) - step;
      add_column(work_.column, work_.pivot, -step);
      work_.column[worst] = released;
      sweep(worst, T(0));
    }
    return false;
  }

  /// The free input that is farthest outside its limits; kHorizon when none is.
  M100_INLINE std::size_t most_violated() const {
    const Pack<T> low = spread(work_.low_rad);
    const Pack<T> high = spread(work_.high_rad);
    const Pack<T> zero = spread(T(0));
    Largest<T> most(Tolerance<T>::kLimit_rad);
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> value = load(work_.column + b * kLanes);
      const Pack<T> above = value - high;
      const Pack<T> below = low - value;
      const Pack<T> outside = larger<T>(above, below);
      const Mask<T> is_free = is_equal<T>(load(work_.tableau.side.data() + b * kLanes), zero);
      most.consider(choose<T>(is_free, outside, zero), b);
    }
    return most.found();
  }

  /// The active input whose multiplier reaches zero first when work_.column moves by -step work_.pivot, before the
  /// whole step; kHorizon when none does.
  M100_INLINE std::size_t first_to_block(T step) const {
    const Pack<T> zero = spread(T(0));
    const Pack<T> whole = spread(step);
    std::uint32_t places = 0;
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> side = load(work_.tableau.side.data() + b * kLanes);
      const Pack<T> shrinks = side * load(work_.pivot + b * kLanes) * whole;
      const Mask<T> blocks = is_below<T>(zero, shrinks) & is_below<T>(side * load(work_.column + b * kLanes), shrinks);
      places |= bits_of<T>(blocks) << (b * kLanes);
    }
    std::size_t first = kHorizon;
    T smallest = T(1);  // share of the step
    for (; places != 0; places &= places - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(places));
      const T share = work_.column[i] / (work_.pivot[i] * step);
      if (share < smallest) {
        smallest = share;
        first = i;
      }
    }
    return first;
  }

  /// Raises the multiplier of input i until the input is at its limit, dropping each active input whose multiplier
  /// would change sign. @returns false: stopped at kMaxChanges.
  M100_INLINE bool enter(std::size_t i) {
    const T side = work_.column[i] > work_.high_rad ? T(1) : T(-1);
    const T target = side > T(0) ? work_.high_rad : work_.low_rad;
    T multiplier = T(0);
    while (changes_ < kMaxChanges) {
      gather(swept(), i, work_.pivot);
      const T full = (work_.column[i] - target) / work_.pivot[i];
      const std::size_t blocking = first_to_block(full);
      const T step = blocking == kHorizon ? full : work_.column[blocking] / work_.pivot[blocking];
      add_column(work_.column, work_.pivot, -step);
      multiplier += step;
      if (blocking == kHorizon) {
        work_.column[i] = multiplier;
        sweep(i, side);
        return true;
      }
      work_.column[blocking] = limit(blocking);
      gather(swept(), blocking, work_.pivot);
      sweep(blocking, T(0));
    }
    return false;
  }

  M100_INLINE T* swept() { return work_.tableau.swept.data(); }

  ActiveSetWork<T> work_;
  std::uint16_t changes_ = 0;
};

}  // namespace m100::mpc::M100_LANES_NAMESPACE
