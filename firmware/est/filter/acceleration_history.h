// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/est/filter/response_step.h"

namespace m100::est {

/// Largest age of a pose that is used.
inline constexpr double kMaxPoseAge_s = 0.25;
inline constexpr std::size_t kHistoryTicks = 32;
static_assert(kMaxPoseAge_s <= static_cast<double>(kHistoryTicks) * kTick_s,
              "the history reaches back to the oldest pose");

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

  /// sum_j T^2 w_j acc_j for an age of at most kMaxPoseAge_s; m.
  S displacement(S age_s) const {
    S sum{0};
    S left = age_s * S(1.0 / kTick_s);  // in ticks; part of the age that lies in tick j and before
    for (std::size_t j = 0; j < kHistoryTicks && left > S(0); ++j) {
      const S weight = left >= S(1) ? left - S(0.5) : S(0.5) * left * left;
      sum += weight * acceleration_[(newest_ + kHistoryTicks - j) % kHistoryTicks];
      left -= S(1);
    }
    return sum * S(kTick_s * kTick_s);
  }

 private:
  std::array<S, kHistoryTicks> acceleration_{};
  std::size_t newest_ = 0;
};

}  // namespace m100::est
