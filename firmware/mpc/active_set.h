// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/mpc/certificate.h"
#include "firmware/mpc/clipping_guess.h"
#include "firmware/mpc/horizontal_mpc.h"
#include "firmware/mpc/lanes.h"
#include "firmware/mpc/swept.h"

namespace m100::mpc::M100_LANES_NAMESPACE {

/// From so many wrong places on, a guess is nearer to the answer than the kept active set.
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
      : table_(table), tableau_(tableau), unconstrained_(unconstrained), low_rad_(low_rad), high_rad_(high_rad) {}

  /// One try. @returns whether the iteration ended by itself; false at the cap.
  M100_INLINE bool run() {
    changes_ = 0;
    evaluate();
    const std::uint32_t wrong = wrong_places();
    if (wrong == 0) {
      return true;
    }
    if (__builtin_popcount(wrong) >= kStale) {
      adopt(guess_by_clipping(table_, unconstrained_, low_rad_, high_rad_, column_, pivot_));
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

  /// The sequence, limits met exactly, refined where T is short of digits. @returns the largest violation of the
  /// optimality conditions.
  M100_INLINE T finish(T* inputs) {
    return Certificate<T>(table_, tableau_, unconstrained_, low_rad_, high_rad_, column_, pivot_, scaled_)
        .finish(inputs);
  }

  std::uint16_t changes() const { return changes_; }

 private:
  M100_INLINE T limit(std::size_t i) const { return tableau_.side[i] > T(0) ? high_rad_ : low_rad_; }

  /// t from the tableau as it is.
  M100_INLINE void evaluate() {
    const Pack<T> zero = spread(T(0));
    const Pack<T> low = spread(low_rad_);
    const Pack<T> high = spread(high_rad_);
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> side = load(tableau_.side.data() + b * kLanes);
      const Pack<T> optimum = load(unconstrained_ + b * kLanes);
      const Mask<T> is_free = is_equal<T>(side, zero);
      const Pack<T> away = choose<T>(is_below<T>(zero, side), high, low) - optimum;
      store<T>(column_ + b * kLanes, choose<T>(is_free, optimum + zero, zero));
      store<T>(pivot_ + b * kLanes, choose<T>(is_free, zero, away));
    }
    settle(pivot_);
    add_product(swept(), pivot_, column_);
  }

  /// Sweeps k in (side != 0) or out (side == 0); pivot_ holds column k.
  /// The column is made afresh, from zeros, instead of leaving it to the update: that would cancel its digits away.
  M100_INLINE_PACKS void sweep(std::size_t k, T side) {
    const T inverse = T(1) / pivot_[k];
    const T sign = side != T(0) ? inverse : -inverse;
    scale_column(scaled_, pivot_, -inverse);
    scaled_[k] = sign;
    clear_below(swept(), k);
    settle(scaled_);
    add_outer_product(swept(), scaled_, pivot_);
    T* row = swept() + packed_row(k);
    const Pack<T> same = spread(sign);
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      if (b > k / kLanes) {
        break;
      }
      store<T>(row + b * kLanes, load(pivot_ + b * kLanes) * same);
    }
    row[k] = -inverse;
    tableau_.side[k] = side;
    ++changes_;
  }

  /// One bit for each input that is free and outside its limits or active and pulled back by its multiplier.
  M100_INLINE std::uint32_t wrong_places() const {
    const Pack<T> low = spread(low_rad_ - Tolerance<T>::kLimit_rad);
    const Pack<T> high = spread(high_rad_ + Tolerance<T>::kLimit_rad);
    const Pack<T> zero = spread(T(0));
    const Pack<T> pulls = spread(-Tolerance<T>::kMultiplier);
    std::uint32_t places = 0;
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> side = load(tableau_.side.data() + b * kLanes);
      const Pack<T> value = load(column_ + b * kLanes);
      const Mask<T> outside = is_below<T>(value, low) | is_below<T>(high, value);
      const Mask<T> wrong = is_below<T>(side * value, pulls) | (is_equal<T>(side, zero) & outside);
      places |= bits_of<T>(wrong) << (b * kLanes);
    }
    return places;
  }

  /// Makes the guess the active set, from the kept one, the empty one or the full one, whose tableau is -H: whichever
  /// is nearest. Inputs that only change their side cost nothing.
  M100_INLINE void adopt(std::uint32_t active) {
    constexpr std::uint32_t kAll = (1U << kHorizon) - 1;
    alignas(32) T side[kHorizon];  // NOLINT(modernize-avoid-c-arrays): scratch
    Column<T> sides;
    sides.read(pivot_);
    sides.write(side);
    std::uint32_t kept = 0;
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Mask<T> is_free = is_equal<T>(load(tableau_.side.data() + b * kLanes), spread(T(0)));
      kept |= (bits_of<T>(is_free) ^ kAllLanes) << (b * kLanes);
    }
    const int from_kept = __builtin_popcount(kept ^ active);
    const int from_empty = __builtin_popcount(active);
    const int from_full = static_cast<int>(kHorizon) - from_empty;
    if (from_kept > from_empty && from_empty <= from_full) {
      start_over(table_, tableau_);
      kept = 0;
    } else if (from_kept > from_full) {
      start_full(table_, tableau_);
      kept = kAll;
    }
    sides.write(tableau_.side.data());
    for (std::uint32_t places = kept ^ active; places != 0; places &= places - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(places));
      gather(swept(), i, pivot_);
      sweep(i, side[i]);
    }
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
      gather(swept(), worst, pivot_);
      const T step = column_[worst] / pivot_[worst];
      const T released = limit(worst) - step;
      add_column(column_, pivot_, -step);
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
      const Pack<T> outside = larger<T>(above, below);
      const Mask<T> is_free = is_equal<T>(load(tableau_.side.data() + b * kLanes), zero);
      most.consider(choose<T>(is_free, outside, zero), b);
    }
    return most.found();
  }

  /// The active input whose multiplier reaches zero first when column_ moves by -step pivot_, before the whole step;
  /// kHorizon when none does.
  M100_INLINE std::size_t first_to_block(T step) const {
    const Pack<T> zero = spread(T(0));
    const Pack<T> whole = spread(step);
    std::uint32_t places = 0;
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> side = load(tableau_.side.data() + b * kLanes);
      const Pack<T> shrinks = side * load(pivot_ + b * kLanes) * whole;
      const Mask<T> blocks = is_below<T>(zero, shrinks) & is_below<T>(side * load(column_ + b * kLanes), shrinks);
      places |= bits_of<T>(blocks) << (b * kLanes);
    }
    std::size_t first = kHorizon;
    T smallest = T(1);  // share of the step
    for (; places != 0; places &= places - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(places));
      const T share = column_[i] / (pivot_[i] * step);
      if (share < smallest) {
        smallest = share;
        first = i;
      }
    }
    return first;
  }

  /// Raises the multiplier of input i until it is at its limit, dropping on the way each active input whose multiplier
  /// would change sign.
  M100_INLINE bool enter(std::size_t i) {
    const T side = column_[i] > high_rad_ ? T(1) : T(-1);
    const T target = side > T(0) ? high_rad_ : low_rad_;
    T multiplier = T(0);
    while (changes_ < kMaxChanges) {
      gather(swept(), i, pivot_);
      const T full = (column_[i] - target) / pivot_[i];
      const std::size_t blocking = first_to_block(full);
      const T step = blocking == kHorizon ? full : column_[blocking] / pivot_[blocking];
      add_column(column_, pivot_, -step);
      multiplier += step;
      if (blocking == kHorizon) {
        column_[i] = multiplier;
        sweep(i, side);
        return true;
      }
      column_[blocking] = limit(blocking);
      gather(swept(), blocking, pivot_);
      sweep(blocking, T(0));
    }
    return false;
  }

  M100_INLINE T* swept() { return tableau_.swept.data(); }

  const GainTable<T>& table_;
  Tableau<T>& tableau_;
  const T* unconstrained_;
  T low_rad_;
  T high_rad_;
  std::uint16_t changes_ = 0;
  alignas(32) T column_[kHorizon];  // NOLINT(modernize-avoid-c-arrays): scratch
  alignas(32) T pivot_[kHorizon];   // NOLINT(modernize-avoid-c-arrays)
  alignas(32) T scaled_[kHorizon];  // NOLINT(modernize-avoid-c-arrays)
};

}  // namespace m100::mpc::M100_LANES_NAMESPACE
