// SPDX-License-Identifier: BSD-3-Clause
// The numbers of the fence, worked out by hand from its equations (geofence_limiter.h), on both axes and towards both
// sides.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

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
      limiter.limit(window, estimate, {}, {});
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
  limiter.limit(window, estimate, {}, {});
  const double gained = 0.5 * 0.46, top = 2.0 + gained;
  EXPECT_NEAR(limiter.reserve_m(), 8.0 - (1.02 + gained * 0.28 + top * top / (2.0 * 2.5)), 1e-9);
}

TEST(FenceNumbers, AWindThatLeavesNothingStillLeavesAnAnswer) {
  GeofenceLimiter<double> limiter(box(1000.0), kBraking);
  est::Estimate<double> estimate;
  estimate.x.velocity_m_s = 1.0;
  estimate.x.disturbance_m_s2 = 4.0;
  ref::Window<double> window;
  limiter.limit(window, estimate, {}, {});
  const double gained = 4.5 * 0.46, top = 1.0 + gained;
  EXPECT_NEAR(limiter.reserve_m(), 1000.0 - (0.51 + gained * 0.28 + top * top / (2.0 * 0.05)), 1e-6);
}

// A stop begins once the way to it plus three sigmas reaches the side. It lasts at least 1 s, and until the speed is
// below 0.3 m/s, whatever room is left meanwhile; so two stops cannot begin within 1 s.
TEST(FenceNumbers, AStopIsFollowedToItsEnd) {
  for (const double direction : {1.0, -1.0}) {
    for (const double room_m : {0.301, 0.299}) {
      GeofenceLimiter<double> limiter(box(8.0), kBraking);
      est::Estimate<double> estimate;
      const core::TimePoint begin(std::chrono::seconds(3));
      const auto limited = [&](int ms) {
        ref::Window<double> window;
        window.x.fill({.position_m = direction});
        limiter.limit(window, estimate, begin + std::chrono::milliseconds(ms), {});
        EXPECT_EQ(window.y[0].position_m, 0.0) << "the other axis is left alone";
        return window.x;
      };
      estimate.x = fast(direction, direction * (8.0 - kStop_m - room_m), 1.0);
      const auto first = limited(0);
      ASSERT_EQ(limiter.brakes(), room_m < 0.3);
      if (!limiter.brakes()) {
        EXPECT_EQ(first[20].position_m, direction);
        continue;
      }
      EXPECT_NEAR(first[0].position_m, estimate.x.position_m, 1e-9) << "from where the aircraft is";
      EXPECT_NEAR(first[0].velocity_m_s, estimate.x.velocity_m_s, 1e-9);
      EXPECT_LT(direction * first[20].position_m, 7.8);
      estimate.x.position_m = 0.0;
      EXPECT_NEAR(limited(100)[0].position_m, first[1].position_m, 1e-9) << "there is room again";
      estimate.x.velocity_m_s = 0.31;
      EXPECT_NEAR(limited(1500)[0].position_m, first[15].position_m, 1e-9) << "it still moves";
      estimate.x.velocity_m_s = 0.29;
      EXPECT_EQ(limited(1510)[0].position_m, direction);
      EXPECT_EQ(limiter.status().stops, 1U);
      estimate.x = fast(direction, direction * (8.0 - kStop_m - room_m), 1.0);
      limited(1520);
      estimate.x.velocity_m_s = 0.0;
      limited(2510);
      EXPECT_TRUE(limiter.brakes());
      limited(2530);
      EXPECT_FALSE(limiter.brakes());
      EXPECT_EQ(limiter.status().stops, 2U);
      limiter.reset();
      EXPECT_EQ(limiter.status().stops, 0U);
    }
  }
}

// Catches a limiter that knows the present tilt alone: a motion that brakes in time is admitted at full forward tilt,
// and the aircraft's deviation from it is added.
TEST(FenceNumbers, AReferenceThatBrakesInTimeIsAdmitted) {
  const ref::AxisReference<double> now{.position_m = 2.0, .velocity_m_s = 2.5, .acceleration_m_s2 = 2.0};
  ref::Window<double> motion;
  for (std::size_t k = 0; k < motion.x.size(); ++k) {  // 0.2 s at that acceleration, then 1.9 s at -1.5 m/s^2
    const double time_s = 0.1 * static_cast<double>(k);
    const auto top = ref::after(now, std::min(time_s, 0.2), 0.0);
    motion.x[k] = time_s < 0.2 ? top : ref::after({top.position_m, top.velocity_m_s, -1.5}, time_s - 0.2, 0.0);
  }
  const ref::AxisReference<double> then = ref::between<double>(motion.x, 0.51);
  EXPECT_NEAR(then.velocity_m_s, 2.9 - 1.5 * 0.31, 1e-9);
  est::Estimate<double> estimate;
  for (const double off_m : {0.0, 0.4}) {
    estimate.x = {.position_m = 2.0 + off_m, .velocity_m_s = 2.5, .tilt_rad = 2.0 / 9.8066};
    const double blows_m_s2 = 0.75 / 3.0;  // of the 1.0 m/s^2 of the class, the speed may hide 0.75
    const double added_m_s = 0.5 * 0.46, top_m_s = then.velocity_m_s + added_m_s;
    const double stops_m = then.position_m + off_m + added_m_s * 0.28 + top_m_s * top_m_s / (2.0 * (2.5 - blows_m_s2));
    for (const double room_m : {0.01, -0.01}) {
      GeofenceLimiter<double> limiter(box(stops_m + room_m), kBraking);
      ref::Window<double> window = motion;
      limiter.limit(window, estimate, {}, {});
      EXPECT_LT(limiter.reserve_m(), -1.0) << "with nothing that brakes in the reference";
      EXPECT_EQ(limiter.brakes(), room_m < 0.0);
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
    limiter.limit(window, estimate, {}, {});
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
      limiter.limit(window, estimate, {}, {});
      EXPECT_NEAR(window.x[3].position_m, direction * one.goal_m, 1e-12) << one.half_m;
      EXPECT_NEAR(window.y[3].position_m, direction * one.goal_m, 1e-12) << one.half_m;
      EXPECT_EQ(window.y[3].velocity_m_s, 0.0);
      EXPECT_NEAR(window.height.position_m, direction > 0.0 ? 3.8 : 0.7, 1e-12);
    }
  }
}

}  // namespace
}  // namespace m100::ctl
