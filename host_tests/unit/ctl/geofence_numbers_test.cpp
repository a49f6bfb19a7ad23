// SPDX-License-Identifier: BSD-3-Clause
// The numbers of the fence, worked out by hand from its equations (geofence_limiter.h), on both axes and towards both
// sides.
#include <gtest/gtest.h>

#include "firmware/ctl/law/geofence_limiter.h"

namespace m100::ctl {
namespace {

constexpr Braking kBraking{.acceleration_m_s2 = 3.0,
                           .max_disturbance_m_s2 = 3.0,
                           .reaction_s = 0.5,
                           .unknown_drag_per_s = 0.3,
                           .drag_per_s = 0.25};
core::Fence box(double half_m) {
  const core::Fence::Side side{-half_m, half_m};
  return {.side = {side, side, core::Fence::Side{0.5, 4.0}}, .wind_m_s = 4.0};  // pushes by 1.0, gusts by 0.3 m/s^2
}

/// The x axis at 2 m/s, tilted by 0.1 rad in the direction of motion, pushed by 0.2 m/s^2. The wind class leaves 0.8
/// m/s^2, of which the speed may hide 0.6 as drag; a third of that counts, so the push is 0.4. With gusts (0.3) and the
/// unobserved offset of the force (0.2) it is 0.9, so 2.1 are left for braking. With one tick until the next check the
/// reaction time is 0.51 s. In the 0.46 s in which the tilt reverses the aircraft gains (0.98066 + 0.9) 0.46 = 0.865104
/// m/s, and it stops within
///   2 * 0.51 + 0.865104 (0.51 - 0.23) + 2.865104^2 / (2 * 2.1) = 3.216710 m.
constexpr double kStop_m = 1.02 + 0.865104 * 0.28 + 2.865104 * 2.865104 / 4.2;

est::AxisEstimate<double> fast(double direction, double position_m, double tilt_sign) {
  return {.position_m = position_m,
          .velocity_m_s = 2.0 * direction,
          .tilt_rad = 0.1 * direction * tilt_sign,
          .disturbance_m_s2 = 0.2 * direction,
          .position_variance_m2 = 0.01};
}

TEST(FenceNumbers, TheReserveIsTheRoomLessTheWayToAStop) {
  for (const double direction : {1.0, -1.0}) {
    for (const bool on_x : {true, false}) {
      GeofenceLimiter<double> limiter(box(8.0), kBraking);
      est::Estimate<double> estimate;
      (on_x ? estimate.x : estimate.y) = fast(direction, direction * 2.0, on_x ? 1.0 : -1.0);
      ref::Window<double> window;
      limiter.limit(window, estimate);
      EXPECT_NEAR(limiter.reserve_m(), 6.0 - kStop_m, 1e-6) << direction << (on_x ? " on x" : " on y");
    }
  }
}

TEST(FenceNumbers, LeaningBackAndHeadWindAreNoHelpThatIsCountedOn) {
  GeofenceLimiter<double> limiter(box(8.0), kBraking);
  est::Estimate<double> estimate;
  estimate.x = fast(1.0, 0.0, 1.0);
  estimate.x.tilt_rad = -0.2;
  estimate.x.disturbance_m_s2 = -1.5;  // 0.6 may be hidden drag, a third counts: -1.3 is still no push
  ref::Window<double> window;
  limiter.limit(window, estimate);
  const double gained = 0.5 * 0.46, top = 2.0 + gained;
  EXPECT_NEAR(limiter.reserve_m(), 8.0 - (1.02 + gained * 0.28 + top * top / (2.0 * 2.5)), 1e-9);
}

TEST(FenceNumbers, AWindThatLeavesNothingStillLeavesAnAnswer) {
  GeofenceLimiter<double> limiter(box(1000.0), kBraking);
  est::Estimate<double> estimate;
  estimate.x.velocity_m_s = 1.0;
  estimate.x.disturbance_m_s2 = 4.0;
  ref::Window<double> window;
  limiter.limit(window, estimate);
  const double gained = 4.5 * 0.46, top = 1.0 + gained;
  EXPECT_NEAR(limiter.reserve_m(), 1000.0 - (0.51 + gained * 0.28 + top * top / (2.0 * 0.05)), 1e-6);
}

// Over the last 0.4 m before the way to a stop plus three sigmas reaches the side, the reference moves behind the
// aircraft.
TEST(FenceNumbers, BrakingIsTakenUpOverFourTenthsOfAMetre) {
  struct Case {
    double room_m, share;
  };
  for (const Case& one : {Case{0.71, 0.0}, Case{0.5, 0.5}, Case{0.4, 0.75}, Case{0.3, 1.0}, Case{0.0, 1.0}}) {
    for (const double direction : {1.0, -1.0}) {
      GeofenceLimiter<double> limiter(box(8.0), kBraking);
      est::Estimate<double> estimate;
      const double place_m = direction * (8.0 - kStop_m - one.room_m);
      estimate.x = fast(direction, place_m, 1.0);
      ref::Window<double> window;
      window.x.fill({.position_m = direction, .velocity_m_s = 0.4, .acceleration_m_s2 = 0.6});
      limiter.limit(window, estimate);
      const double behind_m = place_m - 3.0 * direction;
      EXPECT_EQ(limiter.brakes(), one.share > 0.0) << one.room_m;
      for (const auto& r : window.x) {
        EXPECT_NEAR(r.position_m, direction + one.share * (behind_m - direction), 1e-5) << one.room_m;
        EXPECT_NEAR(r.velocity_m_s, 0.4 * (1.0 - one.share), 1e-5);
        EXPECT_NEAR(r.acceleration_m_s2, 0.6 * (1.0 - one.share), 1e-5);
      }
      EXPECT_EQ(window.y[0].position_m, 0.0) << "the other axis is left alone";
    }
  }
}

TEST(FenceNumbers, BelowWalkingPaceNothingHasToBeBraked) {
  for (const double speed_m_s : {0.299, 0.3}) {
    GeofenceLimiter<double> limiter(box(8.0), kBraking);
    est::Estimate<double> estimate;
    estimate.x.position_m = 7.9;
    estimate.x.velocity_m_s = speed_m_s;
    ref::Window<double> window;
    limiter.limit(window, estimate);
    EXPECT_EQ(limiter.brakes(), speed_m_s == 0.3);
  }
}

TEST(FenceNumbers, GoalsKeepTwentyCentimetresOrAQuarterOfANarrowBox) {
  struct Case {
    double half_m, goal_m;
  };
  for (const Case& one : {Case{5.0, 4.8}, Case{0.4, 0.2}, Case{0.3, 0.15}}) {
    for (const double direction : {1.0, -1.0}) {
      GeofenceLimiter<double> limiter(box(one.half_m), kBraking);
      ref::Window<double> window;
      window.x.fill({.position_m = 9.0 * direction, .velocity_m_s = 1.0});
      window.y.fill({.position_m = 9.0 * direction, .velocity_m_s = 1.0});
      window.height = {.position_m = direction > 0.0 ? 9.0 : -9.0};
      est::Estimate<double> estimate;
      estimate.height_m = 1.5;
      limiter.limit(window, estimate);
      EXPECT_NEAR(window.x[3].position_m, direction * one.goal_m, 1e-12) << one.half_m;
      EXPECT_NEAR(window.y[3].position_m, direction * one.goal_m, 1e-12) << one.half_m;
      EXPECT_EQ(window.y[3].velocity_m_s, 0.0);
      EXPECT_NEAR(window.height.position_m, direction > 0.0 ? 3.8 : 0.7, 1e-12);
    }
  }
}

}  // namespace
}  // namespace m100::ctl
