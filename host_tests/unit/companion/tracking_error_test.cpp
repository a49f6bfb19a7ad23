// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/monitor/tracking_error.h"

#include <gtest/gtest.h>

namespace m100::companion {
namespace {

// Catches a comparison with the reference that leads by the transport delay (0.12 m here), and a first second that
// counts, in which the aircraft goes to the course.
TEST(TrackingError, IsAgainstTheReferenceOfTheSameTimeOnceTheCourseIsReached) {
  constexpr core::Duration kLead(123456);
  constexpr double kSpeed_m_s = 1.0;
  TrackingError error;
  for (int tick = 0; tick < 500; ++tick) {
    const core::TimePoint now{tick * core::kTickPeriod};
    ref::Window<double> reference;
    reference.x[0].position_m = kSpeed_m_s * core::seconds<double>((now + kLead).time_since_epoch());
    const double aside_m = tick < 100 ? 1.0 : 0.02;
    error.update(now, {kSpeed_m_s * core::seconds<double>(now.time_since_epoch()), aside_m, 0.01}, reference, kLead);
    EXPECT_EQ(error.is_known(), tick >= 100);
  }
  EXPECT_NEAR(error.horizontal_rms_m(), 0.02, 1e-9);
  EXPECT_NEAR(error.vertical_rms_m(), 0.01, 1e-9);
  EXPECT_NEAR(error.max_m(), std::hypot(0.02, 0.01), 1e-9);
}

}  // namespace
}  // namespace m100::companion
