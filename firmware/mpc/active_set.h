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

/// From so many wrong places on, a guess is nearer to the answer than the kept active set.
inline constexpr int kStale = 7;

template <typename T>
M100_INLINE void start_over(const GainTable<T>& table, Tableau<T>& tableau) {
  M100_UNROLL(8)
  for (std::size_t i = 0; i < kPackedSize; i += kLanes) {
    store<T>(tableau.swept.data() + i, load(table.inverse_hessian.data() + i));
  }
  M100_UNROLL(5)
  for (std::size_t i = 0; i < kHorizon; i += kLanes) {
    store<T>(tableau.side.data() + i, spread(T(0)));
  }
}

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
      adopt(guess());
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
#ifdef M100_LANES_SCALAR
    const T* row = tableau_.swept.data() + packed_row(k);
    for (std::size_t i = 0; i <= k; ++i) {
      pivot_[i] = row[i];
    }
    const T* at = row + k;
    for (std::size_t i = k + 1; i < kHorizon; ++i) {
      at += padded_row(i - 1);
      pivot_[i] = *at;
    }
#else
    switch (k / kPack) {  // so that every address is a constant and k
      case 0:
        return gather_in_block<0>(k);
      case 1:
        return gather_in_block<1>(k);
      case 2:
        return gather_in_block<2>(k);
      case 3:
        return gather_in_block<3>(k);
      default:
        return gather_in_block<4>(k);
    }
#endif
  }
  template <std::size_t kBlock>
  M100_INLINE void gather_in_block(std::size_t k) {
    static_assert(kHorizon / kPack == 5);
    const T* swept = tableau_.swept.data();
    const T* row = swept + packed_row(kBlock * kPack) + (k % kPack) * (kPack * (kBlock + 1));
    M100_UNROLL(5)
    for (std::size_t b = 0; b <= kBlock; ++b) {
      store<T>(pivot_ + b * kPack, load(row + b * kPack));
    }
    M100_UNROLL(20)
    for (std::size_t i = kBlock * kPack + 1; i < kHorizon; ++i) {
      if (i >= (kBlock + 1) * kPack || i > k) {
        pivot_[i] = swept[packed_row(i) + k];
      }
    }
    settle(pivot_);
  }

  /// Zeros below the diagonal of column k.
  M100_INLINE void clear_below(std::size_t k) {
#ifdef M100_LANES_SCALAR
    T* at = tableau_.swept.data() + packed_row(k) + k;
    for (std::size_t i = k + 1; i < kHorizon; ++i) {
      at += padded_row(i - 1);
      *at = T(0);
    }
#else
    switch (k / kPack) {
      case 0:
        return clear_below_in_block<0>(k);
      case 1:
        return clear_below_in_block<1>(k);
      case 2:
        return clear_below_in_block<2>(k);
      case 3:
        return clear_below_in_block<3>(k);
      default:
        return clear_below_in_block<4>(k);
    }
#endif
  }
  template <std::size_t kBlock>
  M100_INLINE void clear_below_in_block(std::size_t k) {
    M100_UNROLL(20)
    for (std::size_t i = kBlock * kPack + 1; i < kHorizon; ++i) {
      if (i >= (kBlock + 1) * kPack || i > k) {
        tableau_.swept[packed_row(i) + k] = T(0);
      }
    }
  }

  /// column_ += pivot_ * factor
  M100_INLINE void move_along_pivot(T factor) {
    Column<T> sum;
    sum.read(column_);
    sum.add(pivot_, factor);
    sum.write(column_);
  }

  /// column_ += M e, from the lower triangle alone: every row is read once, for the elements left of the diagonal as a
  /// row and for all of them as a column. Sums in four lanes on every machine.
  M100_INLINE void add_product(const T* e) {
    const T* swept = tableau_.swept.data();
#ifdef M100_LANES_SCALAR
    T row_part[kHorizon];  // NOLINT(modernize-avoid-c-arrays): scratch
    const T* row = swept;
    for (std::size_t i = 0; i < kHorizon; ++i) {
      T lanes[kPack] = {};  // NOLINT(modernize-avoid-c-arrays): scratch
      const T same = e[i];
      std::size_t j = 0;
      for (; j + kPack <= i; j += kPack) {
        M100_PRAGMA(GCC unroll 4)
        for (std::size_t l = 0; l < kPack; ++l) {
          lanes[l] = fused(row[j + l], e[j + l], lanes[l]);
        }
        if (same != T(0)) {  // nothing in column_ is -0, so that adding 0 changes no bit
          M100_PRAGMA(GCC unroll 4)
          for (std::size_t l = 0; l < kPack; ++l) {
            column_[j + l] = fused(row[j + l], same, column_[j + l]);
          }
        }
      }
      M100_PRAGMA(GCC unroll 4)
      for (std::size_t l = 0; l < kPack; ++l) {
        const T part = row[j + l];
        lanes[l] = fused(j + l < i ? part : T(0), e[j + l], lanes[l]);
        column_[j + l] = fused(j + l <= i ? part : T(0), same, column_[j + l]);
      }
      row_part[i] = (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
      row += padded_row(i);
    }
    for (std::size_t i = 0; i < kHorizon; ++i) {
      column_[i] += row_part[i];
    }
#else
    Column<T> factor;
    Column<T> sum;
    Column<T> lanes;
    factor.read(e);
    sum.read(column_);
    const Pack<T> zero = spread(T(0));
    const Pack<T> place{0, 1, 2, 3};
    M100_UNROLL(5)
    for (std::size_t block = 0; block < kColumnPacks; ++block) {
      Pack<T> part_of_row[kPack];  // NOLINT(modernize-avoid-c-arrays): registers
      M100_UNROLL(4)
      for (std::size_t r = 0; r < kPack; ++r) {
        const T* row = swept + packed_row(block * kPack + r);
        const Pack<T> same = spread(e[block * kPack + r]);
        const Pack<T> diagonal = spread(T(r));
        Pack<T> in_lanes = zero;
        M100_UNROLL(5)
        for (std::size_t b = 0; b < block; ++b) {
          const Pack<T> part = load(row + b * kPack);
          in_lanes = fused(part, factor.pack[b], in_lanes);
          sum.pack[b] = fused(part, same, sum.pack[b]);
        }
        const Pack<T> last = load(row + block * kPack);
        part_of_row[r] = fused(place < diagonal ? last : zero, factor.pack[block], in_lanes);
        sum.pack[block] = fused(place <= diagonal ? last : zero, same, sum.pack[block]);
      }
      lanes.pack[block] = sums_of<T>(part_of_row[0], part_of_row[1], part_of_row[2], part_of_row[3]);
    }
    M100_UNROLL(5)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      store<T>(column_ + b * kPack, sum.pack[b] + lanes.pack[b]);
    }
#endif
  }

  /// t from the tableau as it is.
  M100_INLINE void evaluate() {
    const Pack<T> zero = spread(T(0));
    const Pack<T> low = spread(low_rad_);
    const Pack<T> high = spread(high_rad_);
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> side = load(tableau_.side.data() + b * kLanes);
      const Pack<T> optimum = load(unconstrained_ + b * kLanes);
      const Mask<T> is_free = side == zero;
      const Pack<T> away = (side > zero ? high : low) - optimum;
      store<T>(column_ + b * kLanes, is_free ? optimum + zero : zero);
      store<T>(pivot_ + b * kLanes, is_free ? zero : away);
    }
    settle(pivot_);
    add_product(pivot_);
  }

  /// Sweeps k in (side != 0) or out (side == 0); pivot_ holds column k.
  /// The column is made afresh, from zeros, instead of leaving it to the update: that would cancel its digits away.
  M100_INLINE void sweep(std::size_t k, T side) {
    T* swept = tableau_.swept.data();
    const T inverse = T(1) / pivot_[k];
    const T sign = side != T(0) ? inverse : -inverse;
    Column<T> scaled;
    scaled.set(pivot_, -inverse);
    scaled.write(scaled_);
    scaled_[k] = sign;
    clear_below(k);
    settle(scaled_);
#ifdef M100_LANES_SCALAR
    for (std::size_t b = 0; b < kHorizon; b += kPack) {  // four columns: their factors stay in registers
      const T in_registers[kPack] = {scaled_[b], scaled_[b + 1], scaled_[b + 2], scaled_[b + 3]};  // NOLINT
      T* part = swept + packed_row(b) + b;
      for (std::size_t i = b; i < kHorizon; ++i) {
        const T factor = pivot_[i];
        M100_PRAGMA(GCC unroll 4)
        for (std::size_t l = 0; l < kPack; ++l) {
          part[l] = fused(in_registers[l], factor, part[l]);
        }
        part += padded_row(i);
      }
    }
#else
    scaled.read(scaled_);
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kHorizon; ++i) {
      T* row = swept + packed_row(i);
      const Pack<T> factor = spread(pivot_[i]);
      M100_UNROLL(20)
      for (std::size_t b = 0; b < i / kLanes + 1; ++b) {
        store<T>(row + b * kLanes, fused(scaled.pack[b], factor, load(row + b * kLanes)));
      }
    }
#endif
    T* row = swept + packed_row(k);
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
      const Mask<T> wrong = (side * value < pulls) | ((side == zero) & ((value < low) | (value > high)));
      places |= bits_of<T>(wrong) << (b * kLanes);
    }
    return places;
  }

  /// The active set that clipping gives when each input is clipped in turn and the later ones make the best of it
  /// (a column of the Cholesky factor of H^-1 each): right in half of all problems, near in most. Sides into pivot_.
  /// @returns one bit for each active input.
  M100_INLINE std::uint32_t guess() {
    std::uint32_t active = 0;
    Column<T> sum;
    sum.read(unconstrained_);
    sum.write(column_);
    const T* gain = table_.clipping_gain.data();
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kHorizon; ++i) {
      const std::size_t block = i / kPack;
      const T value = column_[i];
      pivot_[i] = T(0);
      if (value > high_rad_ || value < low_rad_) {
        pivot_[i] = value > high_rad_ ? T(1) : T(-1);
        active |= 1U << i;
        const Pack<T> away = spread((value > high_rad_ ? high_rad_ : low_rad_) - value);
        M100_UNROLL(20)
        for (std::size_t b = block * kPack / kLanes; b < kColumnPacks; ++b) {
          store<T>(column_ + b * kLanes,
                   fused(load(gain + (b * kLanes - block * kPack)), away, load(column_ + b * kLanes)));
        }
      }
      gain += kHorizon - block * kPack;
    }
    return active;
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
      kept |= bits_of<T>(load(tableau_.side.data() + b * kLanes) != spread(T(0))) << (b * kLanes);
    }
    const int from_kept = __builtin_popcount(kept ^ active);
    const int from_empty = __builtin_popcount(active);
    const int from_full = static_cast<int>(kHorizon) - from_empty;
    if (from_kept > from_empty && from_empty <= from_full) {
      start_over(table_, tableau_);
      kept = 0;
    } else if (from_kept > from_full) {
      start_full();
      kept = kAll;
    }
    sides.write(tableau_.side.data());
    for (std::uint32_t places = kept ^ active; places != 0; places &= places - 1) {
      const auto i = static_cast<std::size_t>(__builtin_ctz(places));
      gather(i);
      sweep(i, side[i]);
    }
  }

  M100_INLINE void start_full() {
    M100_UNROLL(20)
    for (std::size_t i = 0; i < kHorizon; ++i) {
      M100_UNROLL(20)
      for (std::size_t b = 0; b < i / kLanes + 1; ++b) {
        store<T>(tableau_.swept.data() + packed_row(i) + b * kLanes,
                 -load(table_.hessian.data() + i * kHorizon + b * kLanes));
      }
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
    const Pack<T> zero = spread(T(0));
    const Pack<T> whole = spread(step);
    std::uint32_t places = 0;
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Pack<T> side = load(tableau_.side.data() + b * kLanes);
      const Pack<T> shrinks = side * load(pivot_ + b * kLanes) * whole;
      places |= bits_of<T>((shrinks > zero) & (side * load(column_ + b * kLanes) < shrinks)) << (b * kLanes);
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
      const Pack<T> size = g > -g ? g : -g;
      const Pack<T> wrong = side == zero ? size : side * g;
      most = most > wrong ? most : wrong;
    }
    return largest_of<T>(most);
  }

  /// inputs_F -= M_FF gradient_F: one Newton step on the free inputs.
  M100_INLINE void refine(T* inputs) {
    const Pack<T> zero = spread(T(0));
    M100_UNROLL(20)
    for (std::size_t b = 0; b < kColumnPacks; ++b) {
      const Mask<T> is_free = load(tableau_.side.data() + b * kLanes) == zero;
      store<T>(pivot_ + b * kLanes, is_free ? -load(gradient_ + b * kLanes) : zero);
      store<T>(column_ + b * kLanes, load(inputs + b * kLanes));
    }
    settle(pivot_);
    add_product(pivot_);
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
  alignas(32) T scaled_[kHorizon];    // NOLINT(modernize-avoid-c-arrays)
  alignas(32) T gradient_[kHorizon];  // NOLINT(modernize-avoid-c-arrays)
};

}  // namespace m100::mpc::M100_LANES_NAMESPACE
