// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/model/tilt_limit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace m100::model {
namespace {

// Catches a series that is too short, and an angle that is used as its own tangent.
TEST(TiltLimit, ItsSlopeIsItsTangent) {
  for (double tilt_rad = 0.0; tilt_rad <= 0.7; tilt_rad += 0.001) {
    EXPECT_NEAR(slope_at_limit(tilt_rad), std::tan(tilt_rad), 1e-15);  // 1.5 ulp of the divided series
  }
  static_assert(slope_at_limit(0.0) == 0.0);
}

// 25 degrees give 4.573 m/s^2. The angle taken for a slope gives 4.279, which is 23.6 degrees.
TEST(TiltLimit, OfTheDefaultVehicleIsTwentyFiveDegrees) {
  EXPECT_NEAR(acceleration_at_limit_m_s2(Translation{}.tilt_limit_rad), 4.573, 5e-4);
}

}  // namespace
}  // namespace m100::model
