// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/est/estimate.h"

namespace m100::ctl {

/// The slope (tangent of the tilt) that one axis will have `ahead_s` from now, if it goes on turning as it does.
/// @param slope that it has now.
template <typename T>
T slope_soon(const est::AxisEstimate<T>& axis, T slope, T ahead_s) {
  return slope + ahead_s * axis.tilt_rate_rad_s * (T(1) + slope * slope);
}

/// The largest slope that may be commanded while both axes together soon have these: `limit`, less twice what they are
/// beyond it, and half of it at the least.
///
/// What is commanded is not what is flown. A balancing point that is off by 56 counts leans the aircraft by 3 degrees
/// beside its command, whichever way the limit is asked for; so does an attitude loop that gives more than it is told,
/// or overshoots. What is learned of it (input_offset_rad) is learned in seconds, and along the axes of the world, so
/// that a turn of the heading makes it wrong. The tilt itself is measured. An error of e at the limit leaves e / 3 of
/// it beyond the limit.
template <typename T>
T most_slope(T soon_x, T soon_y, T limit) {
  constexpr T kTakenBack = T(2);
  constexpr T kLeastShare = T(0.5);
  const T square = soon_x * soon_x + soon_y * soon_y;
  if (!(square > limit * limit)) {
    return limit;
  }
  const T most = limit - kTakenBack * (core::sqrt(square) - limit);
  return most > kLeastShare * limit ? most : kLeastShare * limit;
}

}  // namespace m100::ctl
