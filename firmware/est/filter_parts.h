// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/core/fixed_point.h"
#include "firmware/est/attitude_step.h"
#include "firmware/est/units.h"

// What the filters of a horizontal axis and of the height have in common.
namespace m100::est {

template <typename S>
S limited(S value, double limit) {
  const S high = core::Arithmetic<S>::template number<double>(limit);
  const S low = core::Arithmetic<S>::template number<double>(-limit);
  return value > high ? high : (value < low ? low : value);
}

/// false for NaN.
template <typename S>
bool inside(S value, double limit) {
  return value <= core::Arithmetic<S>::template number<double>(limit) &&
         value >= core::Arithmetic<S>::template number<double>(-limit);
}

/// Commands that act in this tick, in the one before and in the one after.
template <typename S>
struct ActingInputs {
  S now{};
  S before{};
  S after{};
};

/// An AttitudeStep over one tick, in the filter's unit of time.
template <typename S>
struct ResponseStep {
  S oo{}, o_r{}, o_u{}, o_jump{}, ro{}, rr{}, r_u{}, r_next{}, r_jump{};

  struct State {
    S output{};
    S rate{};
  };

  static ResponseStep of(const AttitudeStep& step) {
    const auto number = [](double value) { return core::Arithmetic<S>::template number<double>(value); };
    return {.oo = number(step.oo),
            .o_r = number(step.o_r / kTimeUnit_s),
            .o_u = number(step.o_u),
            .o_jump = number(step.o_jump),
            .ro = number(step.ro * kTimeUnit_s),
            .rr = number(step.rr),
            .r_u = number(step.r_u * kTimeUnit_s),
            .r_next = number(step.r_next * kTimeUnit_s),
            .r_jump = number(step.r_jump * kTimeUnit_s)};
  }

  /// @param offset steady difference between the command and what the output goes to
  State advance(core::Arithmetic<S>& a, const State& from, const ActingInputs<S>& input, S offset) const {
    const S wanted = a.narrow(a.widen(input.now) + a.widen(offset));
    const S wanted_after = a.narrow(a.widen(input.after) + a.widen(offset));
    const S jump = a.narrow(a.widen(input.now) - a.widen(input.before));
    return {.output = a.narrow(a.product(oo, from.output) + a.product(o_r, from.rate) + a.product(o_u, wanted) +
                               a.product(o_jump, jump)),
            .rate = a.narrow(a.product(ro, from.output) + a.product(rr, from.rate) + a.product(r_u, wanted) +
                             a.product(r_next, wanted_after) + a.product(r_jump, jump))};
  }
};

/// Whether a position's innovation is inside 6 sigmas, or inside what may have happened unseen; never beyond 1 m.
/// @param s scaled variance of the innovation @param scale the unit of the position is 2^scale m
template <typename S>
bool inside_gate(core::Arithmetic<S>& a, S innovation, S s, int scale, S unseen_m) {
  constexpr double kGateSigmas = 6.0;
  constexpr double kLargestInnovation_m = 1.0;
  constexpr double kLargestScaled = 90.0;  // its square fits beside the variances
  const auto number = [](double value) { return core::Arithmetic<S>::template number<double>(value); };
  const S size = innovation < S{} ? a.narrow(-a.widen(innovation)) : innovation;
  if (!(size <= number(kLargestInnovation_m))) {
    return false;
  }
  bool inside_sigmas = false;
  if (size < a.narrow(a.scaled(a.widen(number(kLargestScaled)), scale))) {
    const S scaled = a.narrow(a.scaled(a.widen(size), -scale));
    inside_sigmas = a.product(scaled, scaled) <= a.product(s, number(kGateSigmas * kGateSigmas));
  }
  return inside_sigmas || size <= unseen_m;
}

/// x += gain innovation. The gain first, in 64 bits, then the scale: a gain in plain units would not fit.
template <typename S, std::size_t kStates>
void add_correction(core::Arithmetic<S>& a, std::array<S, kStates>& x, const std::array<S, kStates>& gain, S innovation,
                    const std::array<int, kStates>& scales, int measured) {
  for (std::size_t i = 0; i < kStates; ++i) {
    const auto correction =
        a.scaled(a.product(gain[i], innovation), scales[i] - scales[static_cast<std::size_t>(measured)]);
    x[i] = a.narrow(a.widen(x[i]) + correction);
  }
}

/// 2^exponent.
constexpr double power_of_two(int exponent) {
  double value = 1.0;
  for (int i = 0; i < exponent; ++i) {
    value *= 2.0;
  }
  for (int i = 0; i > exponent; --i) {
    value *= 0.5;
  }
  return value;
}

}  // namespace m100::est
