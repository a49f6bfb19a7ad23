// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "firmware/core/fixed_point.h"
#include "firmware/core/maths.h"
#include "firmware/est/filter/units.h"
#include "firmware/model/axis_step.h"

// Shared by the filters of a horizontal axis, of the height and of the yaw, and by the gate of poses (fuse_pose.cpp).
namespace m100::est {

template <typename S>
S limited(S value, double limit) {
  const S high = core::Arithmetic<S>::template number<double>(limit);
  const S low = core::Arithmetic<S>::template number<double>(-limit);
  return value > high ? high : (value < low ? low : value);
}

/// Whether |value| <= limit; false for NaN.
template <typename S>
bool inside(S value, double limit) {
  return value <= core::Arithmetic<S>::template number<double>(limit) &&
         value >= core::Arithmetic<S>::template number<double>(-limit);
}

/// The commands that act in this, the previous and the next tick. `after` equals `now` if the delay is less than a
/// tick.
template <typename S>
struct ActingInputs {
  S now{};
  S before{};
  S after{};
};

/// Smallest time constant of a first-order axis in the filters. A smaller one would exceed the range of fixed point.
inline constexpr double kFastestTimeConstant_s = 0.01;

/// Response of an axis over one tick, as the filters use it. A first-order axis that is faster than
/// kFastestTimeConstant_s gets that time constant, and so does an axis that is not identified.
inline model::AxisStep tick_of(model::StickAxis axis) {
  if (!axis.is_identified() || (axis.is_first_order() && axis.time_constant_s < kFastestTimeConstant_s)) {
    axis.time_constant_s = kFastestTimeConstant_s;
  }
  return model::axis_step(axis, kTick_s);
}

/// A model::AxisStep over one tick, in the filter's unit of time.
template <typename S>
struct ResponseStep {
  S oo{}, o_r{}, o_u{}, o_jump{}, ro{}, rr{}, r_u{}, r_next{}, r_jump{};

  struct State {
    S output{};
    S rate{};
  };

  static ResponseStep of(const model::AxisStep& step) {
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

  /// @param offset final value of the output minus the command
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

/// 2^exponent, for exponents from -1022 to 1023 in double, from -126 to 127 in float.
template <typename Real = double>
constexpr Real power_of_two(int exponent) {
  if constexpr (sizeof(Real) == sizeof(double)) {
    return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52U);
  } else {
    return std::bit_cast<float>(static_cast<std::uint32_t>(exponent + 127) << 23U);
  }
}

/// The larger of two variances, in units of 4^scale: `scaled`, which is in these units, and `variance`, which is in SI
/// or the filter's unit of time; 0 or NaN: none.
/// @param most in these units: the largest variance in fixed point
template <typename S>
S larger_variance(S scaled, float variance, int scale, float most) {
  if (!(variance > 0.F)) {
    return scaled;
  }
  const float wanted = variance * power_of_two<float>(-2 * scale);
  const bool fits = std::is_floating_point_v<S> || wanted < most;
  const S number = core::Arithmetic<S>::template number<float>(fits ? wanted : most);
  return number > scaled ? number : scaled;
}

/// Largest variance of a pose in fixed point, in units of 4^scale m^2: with it, the variance of the position stays
/// below the ceiling of the covariance at 5 poses a second.
inline constexpr float kMaxFixedPose = 8.F;
/// Largest variance after a reset in fixed point.
inline constexpr float kMaxFixedReset = 64.F;

/// Variances of a position and a velocity as poses give them at a start or a reset.
struct MotionVariance {
  float position_m2 = 0.F;
  float velocity_m2 = 0.F;  ///< per unit of time squared
};

inline constexpr double kGateSigmas = 6.0;
inline constexpr double kLargestInnovation_m = 1.0;

/// Whether a position's innovation is at most 6 sigmas or at most unseen_m. An innovation above 1 m is inside only if
/// it is at most 6 sigmas of the pose's own noise: without this, only the poses near the prediction would be used, and
/// they would confirm it.
/// @param s scaled variance of the innovation
/// @param noise scaled variance of the pose
/// @param scale the unit of the position is 2^scale m
template <typename S>
bool inside_gate(core::Arithmetic<S>& a, S innovation, S s, S noise, int scale, S unseen_m) {
  constexpr double kLargestScaled = 90.0;  // in fixed point: its square fits beside the variances
  const auto number = [](double value) { return core::Arithmetic<S>::template number<double>(value); };
  const S size = innovation < S{} ? a.narrow(-a.widen(innovation)) : innovation;
  const bool is_near = size <= number(kLargestInnovation_m);
  bool inside_sigmas = false;
  if (std::is_floating_point_v<S> || size < a.narrow(a.scaled(a.widen(number(kLargestScaled)), scale))) {
    const S scaled = a.narrow(a.scaled(a.widen(size), -scale));
    inside_sigmas = a.product(scaled, scaled) <= a.product(is_near ? s : noise, number(kGateSigmas * kGateSigmas));
  }
  return inside_sigmas || (is_near && size <= unseen_m);
}

/// The largest innovation that inside_gate() accepts, for messages and the log; m.
template <typename Real, typename S>
Real gate_m(S s, S noise, int scale, Real unseen_m) {
  const auto sigmas_m = [scale](S variance) {
    return static_cast<Real>(kGateSigmas) * power_of_two<Real>(scale) *
           core::sqrt(core::Arithmetic<S>::template real<Real>(variance));
  };
  const Real gate = sigmas_m(s) > unseen_m ? sigmas_m(s) : unseen_m;
  const Real most = core::clamp(sigmas_m(noise), static_cast<Real>(kLargestInnovation_m), gate);
  return gate < most ? gate : most;
}

/// x += gain * innovation, converted from the scaled units of the covariance.
template <typename S, std::size_t kStates>
void add_correction(core::Arithmetic<S>& a, std::array<S, kStates>& x, const std::array<S, kStates>& gain, S innovation,
                    const std::array<int, kStates>& scales, int measured) {
  for (std::size_t i = 0; i < kStates; ++i) {
    const auto correction =
        a.scaled(a.product(gain[i], innovation), scales[i] - scales[static_cast<std::size_t>(measured)]);
    x[i] = a.narrow(a.widen(x[i]) + correction);
  }
}

}  // namespace m100::est
