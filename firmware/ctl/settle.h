// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/core/tilt.h"
#include "firmware/ctl/command.h"
#include "firmware/est/estimate.h"
#include "firmware/model/vehicle.h"

namespace m100::ctl {

/// The command that brings the aircraft to a stand without a course, and holds it against trim and wind as they were
/// last estimated: what the ladder lets through in its level rung. Per axis of the yaw-free frame
///   v' = -k v,  |k v| <= a:  slope = +-(v' - d) / g - m
/// Both slopes together are at most tan(30 degrees), the law's own limit, and keep their direction.
/// While no pose comes the velocity is the model's prediction; where its own sigma says that it is worthless, trim and
/// wind alone are held. Level where there is no prediction. No climb, no turn: the autopilot holds the height.
template <typename T>
Command<T> settle(const est::Estimate<T>& estimate) {
  constexpr T kRate_per_s = static_cast<T>(1.2);        // below a third of the attitude loop's bandwidth
  constexpr T kMostBraking_m_s2 = static_cast<T>(4.0);  // what the fence reckons with, too
  constexpr T kWorthless_m2_s2 = static_cast<T>(1.0);
  constexpr T kMostSlope = static_cast<T>(0.5773502691896258);  // tan 30 deg: FlightLawOptions
  constexpr T kPerGravity = static_cast<T>(1.0 / model::kGravity_m_s2);
  if (!estimate.predicts) {
    return {};
  }
  const auto slope = [=](const est::AxisEstimate<T>& axis, T sign) {
    const bool known = axis.velocity_variance_m2_s2 < kWorthless_m2_s2;
    const T braking_m_s2 =
        known ? core::clamp(-kRate_per_s * axis.velocity_m_s, -kMostBraking_m_s2, kMostBraking_m_s2) : T(0);
    return sign * (braking_m_s2 - axis.disturbance_m_s2) * kPerGravity - axis.input_offset_rad;
  };
  const T x = slope(estimate.x, T(1));
  const T y = slope(estimate.y, T(-1));
  const T size = core::sqrt(x * x + y * y);
  const T share = size > kMostSlope ? kMostSlope / size : T(1);
  const core::Euler<T> attitude = core::attitude_of(core::Slope<T>{.x = share * x, .y = share * y}, estimate.yaw_rad,
                                                    core::turn_of(estimate.yaw_rad));
  return {.roll_rad = attitude.roll_rad, .pitch_rad = attitude.pitch_rad};
}

}  // namespace m100::ctl
