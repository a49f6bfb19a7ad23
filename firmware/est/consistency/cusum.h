// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"

namespace m100::est {

/// Change detector: whether two channels contradict each other, from how long and by how much they disagree. It is a
/// one-sided sum (CUSUM) of a function of r = disagreement / allowed:
///   S' = r - 1            for r up to 2
///      = (r^2 - 1) / 3    beyond, at most 4
/// The sum is limited to 0 .. 2 kThreshold_s. Above kThreshold_s the channels contradict each other. A disagreement of
/// twice the allowed one takes 0.5 s; one within the allowed value never adds up.
template <typename T>
class Cusum {
 public:
  static constexpr T kThreshold_s = T(0.5);

  void add(T disagreement, T allowed, T step_s) {
    const T ratio = disagreement / allowed;
    const T weight = ratio < T(2) ? ratio - T(1) : (ratio * ratio - T(1)) * static_cast<T>(1.0 / 3.0);
    sum_s_ = core::clamp(sum_s_ + (weight < kMaxWeight ? weight : kMaxWeight) * step_s, T(0), T(2) * kThreshold_s);
  }
  bool exceeds_threshold() const { return sum_s_ > kThreshold_s; }

 private:
  static constexpr T kMaxWeight = T(4);

  T sum_s_{0};
};

/// The values of one check: the disagreement in the newest tick, the largest disagreement that a healthy flight may
/// show (same unit), and the sum over all ticks.
template <typename T>
struct CheckEvidence {
  T residual{0};
  T allowed{1};
  Cusum<T> cusum;

  void add(T step_s) { cusum.add(residual, allowed, step_s); }
};

}  // namespace m100::est
