// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/time.h"
#include "firmware/model/axis_step.h"

namespace m100::est {

inline constexpr double kTick_s = core::seconds<double>(core::kTickPeriod);

/// The commands that act in this, the previous and the next tick. `after` equals `now` if the delay is less than a
/// tick.
template <typename S>
struct ActingInputs {
  S now{0}, before{0}, after{0};

  /// In the arithmetic T.
  template <typename T>
  ActingInputs<T> as() const {
    return {.now = T(now), .before = T(before), .after = T(after)};
  }
};

/// Smallest time constant of a first-order axis in the filters: one tick. A faster one cannot be seen in the poses.
inline constexpr double kFastestTimeConstant_s = kTick_s;

/// Response of an axis over one tick, as the filters use it. A first-order axis that is faster than
/// kFastestTimeConstant_s gets that time constant, and so does an axis that is not identified.
inline model::AxisStep tick_of(model::StickAxis axis) {
  if (!axis.is_identified() || (axis.is_first_order() && axis.time_constant_s < kFastestTimeConstant_s)) {
    axis.time_constant_s = kFastestTimeConstant_s;
  }
  return model::axis_step(axis, kTick_s);
}

/// A model::AxisStep over one tick in the filters' arithmetic.
template <typename S>
struct ResponseStep {
  S oo{0}, o_r{0}, o_u{0}, o_jump{0}, ro{0}, rr{0}, r_u{0}, r_next{0}, r_jump{0};

  struct State {
    S output{0}, rate{0};
  };

  static ResponseStep of(const model::AxisStep& step) {
    return {S(step.oo), S(step.o_r), S(step.o_u),    S(step.o_jump), S(step.ro),
            S(step.rr), S(step.r_u), S(step.r_next), S(step.r_jump)};
  }

  /// @param offset final value of the output minus the command
  State advance(const State& from, const ActingInputs<S>& input, S offset) const {
    const S wanted = input.now + offset;
    const S wanted_after = input.after + offset;
    const S jump = input.now - input.before;
    return {.output = oo * from.output + o_r * from.rate + o_u * wanted + o_jump * jump,
            .rate = ro * from.output + rr * from.rate + r_u * wanted + r_next * wanted_after + r_jump * jump};
  }
};

}  // namespace m100::est
