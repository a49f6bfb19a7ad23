// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"
#include "firmware/ctl/command.h"
#include "firmware/ctl/law/braking.h"
#include "firmware/ctl/law/slope_limit.h"
#include "firmware/est/estimate.h"
#include "firmware/model/vehicle.h"

namespace m100::ctl {

/// The command of the failsafe's level state. It stops the aircraft without a course and then holds it against the
/// input offset m (trim) and the disturbance d (wind), as last estimated. Per axis of the yaw-free frame:
///   v' = -k s (1 + (s / s1)^2),  limited to the vehicle's braking;  slope = +-(v' - d) / g - m
/// s is the speed predicted for one reaction time t from now, and k t = 0.7. At s = s1 the linear part -k s is half of
/// the vehicle's braking. Both slopes together are limited to tan(30 degrees), or less if the predicted tilt exceeds
/// that (slope_limit.h). If the sigma of the velocity is 1 m/s or more, only trim and wind are compensated. Without a
/// valid prediction the command is level. Climb and yaw rate are 0.
template <typename T>
Command<T> brake_and_hold(const est::Estimate<T>& estimate, const Braking& braking) {
  const T ahead_s = static_cast<T>(braking.reaction_s);
  const T rate_per_s = static_cast<T>(0.7 / braking.reaction_s);
  const T most_m_s2 = static_cast<T>(braking.acceleration_m_s2);
  constexpr T kWorthless_m2_s2 = static_cast<T>(1.0);
  constexpr T kMaxSlope = static_cast<T>(0.5773502691896258);  // tan 30 deg: FlightLawOptions
  const T acts_s = static_cast<T>(braking.acts_s);
  constexpr T kPerGravity = static_cast<T>(1.0 / model::kGravity_m_s2);
  if (!estimate.prediction_valid) {
    return {};
  }
  const auto slope = [=](const est::AxisEstimate<T>& axis, T sign) {
    const bool known = axis.velocity_variance_m2_s2 < kWorthless_m2_s2;
    const T now_m_s2 = sign * static_cast<T>(model::kGravity_m_s2) * axis.tilt_rad + axis.disturbance_m_s2;
    const T soon_m_s = axis.velocity_m_s + ahead_s * now_m_s2;
    const T linear_m_s2 = rate_per_s * soon_m_s;
    const T share = T(2) * linear_m_s2 / most_m_s2;
    const T hard_m_s2 = -linear_m_s2 * (T(1) + share * share);
    const T braking_m_s2 = known ? core::clamp(hard_m_s2, -most_m_s2, most_m_s2) : T(0);
    const T flown = sign * (braking_m_s2 - axis.disturbance_m_s2) * kPerGravity;
    return flown - added_slope(flown, axis.input_offset_rad);
  };
  const T x = slope(estimate.x, T(1));
  const T y = slope(estimate.y, T(-1));
  const auto soon = [acts_s](const est::AxisEstimate<T>& axis) {
    return predicted_slope(axis, core::tan(axis.tilt_rad), acts_s);
  };
  const T most = max_slope(soon(estimate.x), soon(estimate.y), kMaxSlope);
  const T size = core::sqrt(x * x + y * y);
  const T share = size > most ? most / size : T(1);
  const core::Euler<T> attitude = core::attitude_of(core::Slope<T>{.x = share * x, .y = share * y}, estimate.yaw_rad,
                                                    core::sin_cos_of(estimate.yaw_rad));
  return {.roll_rad = attitude.roll_rad, .pitch_rad = attitude.pitch_rad};
}

}  // namespace m100::ctl
