// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/fixed_point.h"
#include "firmware/est/filter/units.h"

namespace m100::est {

/// Largest age of a pose that is used.
inline constexpr double kMaxPoseAge_s = 0.25;
inline constexpr std::size_t kHistoryTicks = 32;
static_assert(kMaxPoseAge_s <= static_cast<double>(kHistoryTicks) * kTick_s,
              "the history reaches back to the oldest pose");

/// Age of a measurement in the filter's units, clamped to [0, kMaxPoseAge_s].
template <typename S>
struct MeasurementAge {
  S ticks{};        ///< age / 10 ms
  S units{};        ///< age / 0.64 s: a
  S half_square{};  ///< a^2 / 2

  template <typename Real>
  static MeasurementAge of(Real age_s) {
    using Number = core::Arithmetic<S>;
    constexpr Real kMax_s = static_cast<Real>(kMaxPoseAge_s);
    const Real limited_s = age_s > Real(0) ? (age_s < kMax_s ? age_s : kMax_s) : Real(0);
    const Real units = limited_s / static_cast<Real>(kTimeUnit_s);
    return {.ticks = Number::template number<Real>(limited_s / static_cast<Real>(kTick_s)),
            .units = Number::template number<Real>(units),
            .half_square = Number::template number<Real>(Real(0.5) * units * units)};
  }
};

/// Accelerations of the last ticks, each constant over its tick. They relate the position a time a ago to the present
/// state, as the model integrates:
///   p(t - a) = p(t) - a v(t) + a^2/2 d + sum_j T^2 w_j acc_j
/// T is the tick, acc the acceleration without the disturbance d, and j counts ticks backwards. A whole tick has the
/// weight w_j = a/T - j - 1/2. The oldest tick, of which the fraction f lies within a, has w_j = f^2/2. Cost: one
/// product per tick of age.
template <typename S>
class AccelerationHistory {
 public:
  void add(S acceleration) {
    newest_ = (newest_ + 1) % kHistoryTicks;
    acceleration_[newest_] = acceleration;
  }

  /// sum_j T^2 w_j acc_j for an age of a = age_ticks T; m.
  S displacement(core::Arithmetic<S>& arithmetic, S age_ticks) const {
    using Number = core::Arithmetic<S>;
    const S one = Number::template number<double>(1.0);
    const S half = Number::template number<double>(0.5);
    typename Number::Wide sum{};
    S left = age_ticks;  // in ticks; part of the age that lies in tick j and before
    for (std::size_t j = 0; j < kHistoryTicks && left > S{}; ++j) {
      const S acceleration = acceleration_[(newest_ + kHistoryTicks - j) % kHistoryTicks];
      const bool whole = left >= one;
      const S weight = whole ? arithmetic.narrow(arithmetic.widen(left) - arithmetic.widen(half))
                             : arithmetic.narrow(arithmetic.scaled(arithmetic.product(left, left), -1));
      sum += arithmetic.scaled(arithmetic.product(acceleration, weight), 2 * kTickExponent);
      left = whole ? arithmetic.narrow(arithmetic.widen(left) - arithmetic.widen(one)) : S{};
    }
    return arithmetic.narrow(sum);
  }

 private:
  std::array<S, kHistoryTicks> acceleration_{};
  std::size_t newest_ = 0;
};

}  // namespace m100::est
