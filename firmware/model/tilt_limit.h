// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/assert.h"
#include "firmware/model/vehicle.h"

namespace m100::model {

/// Tangent of a tilt limit of 0 to 0.7 rad, within 1e-15. The horizontal acceleration of an aircraft that keeps its
/// height is gravity times this slope, so the input bound of the MPC is the slope, not the angle. Unlike core::tan it
/// is a constant expression.
constexpr double slope_at_limit(double tilt_limit_rad) {
  M100_ASSERT(tilt_limit_rad >= 0.0 && tilt_limit_rad <= 0.7);
  double sine = 0.0, cosine = 0.0, term = 1.0;
  for (int k = 0; k < 20; k += 2) {  // Taylor; 0.7^20 / 20! is 3e-22
    const double next = term * tilt_limit_rad / (k + 1);
    cosine += term;
    sine += next;
    term = -next * tilt_limit_rad / (k + 2);
  }
  return sine / cosine;
}

/// The horizontal acceleration at a tilt limit, without drag, wind and tilt gain.
constexpr double acceleration_at_limit_m_s2(double tilt_limit_rad) {
  return kGravity_m_s2 * slope_at_limit(tilt_limit_rad);
}

}  // namespace m100::model
