// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"
#include "firmware/ctl/command.h"
#include "firmware/ctl/law/braking.h"
#include "firmware/ctl/law/slope_limit.h"
#include "firmware/est/estimate.h"
#include "firmware/model/vehicle.h"

namespace m100::ctl {

/// The command of the failsafe's level state. It stops the aircraft without a course and then holds it against the
/// input offset m (trim) and the disturbance d (wind), as last estimated. In the plane, of the yaw-free frame:
///   v' = -k s (1 + (|s| / s1)^2),  at most A - d s / |s|;  slope = +-(v' - d) / g - m
/// s is the velocity that would be left if a command without acceleration were given now. With the tilt t it is
///   s = v + lag (d +- g t) +- g lag2 t'   (Braking::lag_s, Braking::lag2_s2);   k lag = 0.7
/// A is Braking::tilted_m_s2; what d takes of it in the direction of s is not there to brake. At |s| = s1 the linear
/// part k |s| is half of the limit. The slope is limited to tan(30 degrees), or less if the predicted tilt exceeds that
/// (slope_limit.h). If the sigma of a velocity is 1 m/s or more, only trim and wind are compensated on its axis.
/// Without a valid prediction the command is level. Climb and yaw rate are 0.
template <typename T>
Command<T> brake_and_hold(const est::Estimate<T>& estimate, const Braking& braking) {
  constexpr T kGravity_m_s2 = static_cast<T>(model::kGravity_m_s2);
  constexpr T kWorthless_m2_s2 = static_cast<T>(1.0);
  constexpr T kMaxSlope = static_cast<T>(0.5773502691896258);  // tan 30 deg: FlightLawOptions
  constexpr T kMinShare = static_cast<T>(0.25);                // of A, that brakes in any wind
  if (!estimate.prediction_valid) {
    return {};
  }
  const T lag_s = static_cast<T>(braking.lag_s), lag2_s2 = static_cast<T>(braking.lag2_s2);
  const T rate_per_s = static_cast<T>(0.7 / braking.lag_s), acts_s = static_cast<T>(braking.acts_s);
  const T tilted_m_s2 = static_cast<T>(braking.tilted_m_s2);
  const auto left_m_s = [=](const est::AxisEstimate<T>& axis, T sign) {
    const T tilt_s = lag_s * axis.tilt_rad + lag2_s2 * axis.tilt_rate_rad_s;
    const T left = axis.velocity_m_s + lag_s * axis.disturbance_m_s2 + sign * kGravity_m_s2 * tilt_s;
    return axis.velocity_variance_m2_s2 < kWorthless_m2_s2 ? left : T(0);
  };
  const T x_m_s = left_m_s(estimate.x, T(1));
  const T y_m_s = left_m_s(estimate.y, T(-1));
  const T speed_m_s = core::sqrt(x_m_s * x_m_s + y_m_s * y_m_s);
  const T blown_m2_s3 = x_m_s * estimate.x.disturbance_m_s2 + y_m_s * estimate.y.disturbance_m_s2;
  const T against_m_s2 = speed_m_s > T(0) ? tilted_m_s2 - blown_m2_s3 / speed_m_s : tilted_m_s2;
  const T most_m_s2 = std::max(against_m_s2, kMinShare * tilted_m_s2);
  const T share = T(2) * rate_per_s * speed_m_s / most_m_s2;
  const T wanted_per_s = rate_per_s * (T(1) + share * share);
  const T per_s = wanted_per_s * speed_m_s > most_m_s2 ? most_m_s2 / speed_m_s : wanted_per_s;
  const auto slope = [=](const est::AxisEstimate<T>& axis, T sign, T axis_m_s) {
    const T flown = sign * (-per_s * axis_m_s - axis.disturbance_m_s2) * static_cast<T>(1.0 / model::kGravity_m_s2);
    return flown - added_slope(flown, axis.input_offset_rad);
  };
  const T x = slope(estimate.x, T(1), x_m_s);
  const T y = slope(estimate.y, T(-1), y_m_s);
  const auto soon = [acts_s](const est::AxisEstimate<T>& axis) {
    return predicted_slope(axis, core::tan(axis.tilt_rad), acts_s);
  };
  const T most = max_slope(soon(estimate.x), soon(estimate.y), kMaxSlope);
  const T size = core::sqrt(x * x + y * y);
  const T kept = size > most ? most / size : T(1);
  const core::Euler<T> attitude = core::attitude_of(core::Slope<T>{.x = kept * x, .y = kept * y}, estimate.yaw_rad,
                                                    core::sin_cos_of(estimate.yaw_rad));
  return {.roll_rad = attitude.roll_rad, .pitch_rad = attitude.pitch_rad};
}

}  // namespace m100::ctl
