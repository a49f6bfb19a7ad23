// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/est/estimate.h"

namespace m100::ctl {

/// The slope (tangent of the tilt) of one axis `ahead_s` from now, if its tilt rate stays constant.
/// @param slope the present one
template <typename T>
T predicted_slope(const est::AxisEstimate<T>& axis, T slope, T ahead_s) {
  return slope + ahead_s * axis.tilt_rate_rad_s * (T(1) + slope * slope);
}

/// What a small angle adds to a slope, to first order: d tan a = (1 + tan^2 a) d a.
template <typename T>
T added_slope(T slope, T angle_rad) {
  return angle_rad * (T(1) + slope * slope);
}

/// The largest slope of both axes together that may be commanded while the aircraft is about to have the slopes soon_x
/// and soon_y: `limit`, minus twice the amount by which their root of squares exceeds it, but at least half of `limit`.
///
/// The flown tilt differs from the commanded one by errors of trim and of the attitude loop. With this reduction an
/// error e makes the flown tilt exceed the limit by e / 3.
template <typename T>
T max_slope(T soon_x, T soon_y, T limit) {
  constexpr T kTakenBack = T(2);
  constexpr T kMinShare = T(0.5);
  const T square = soon_x * soon_x + soon_y * soon_y;
  if (!(square > limit * limit)) {
    return limit;
  }
  const T most = limit - kTakenBack * (core::sqrt(square) - limit);
  return most > kMinShare * limit ? most : kMinShare * limit;
}

}  // namespace m100::ctl
