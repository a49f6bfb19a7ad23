// SPDX-License-Identifier: BSD-3-Clause
// What the observer estimates while ticks are late, poses are missing or telemetry is silent.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "firmware/est/filter/disturbance_ekf.h"
#include "host_tests/unit/est/observed_vehicle.h"

namespace m100::est {
namespace {

using std::chrono::milliseconds;

/// A level aircraft at constant speed, measured without noise; the poses have no age.
template <typename Ekf, typename Real>
struct Glide {
  Ekf filter{vehicle()};
  core::TimePoint now{};
  double speed_m_s = 0.0;
  double off_m = 0.0;  ///< of the pose
  double rate_z_rad_s = 0.0;
  double variance_m2 = 0.0;
  bool poses = true;
  bool attitudes = true;
  double roll_rad = 0.0;

  double x_m() const { return speed_m_s * core::seconds<double>(now.time_since_epoch()); }
  Estimate<Real> tick(core::Duration elapsed = core::kTickPeriod) {
    now += elapsed;
    Measurement<Real> m;
    m.now = now;
    m.attitude.is_new = attitudes;
    m.attitude.roll_rad = static_cast<Real>(roll_rad);
    m.attitude.rate_b_rad_s.z() = static_cast<Real>(rate_z_rad_s);
    m.pose.is_new = poses;
    m.pose.set_captured_at(now);
    m.pose.position_w_m = {static_cast<Real>(x_m() + off_m), Real(0), Real(1.5)};
    m.pose.yaw_rad = static_cast<Real>(rate_z_rad_s * core::seconds<double>(now.time_since_epoch()));
    m.pose.position_variance_m2.setConstant(static_cast<Real>(variance_m2));
    return filter.update(m, {}, elapsed);
  }
  Estimate<Real> run(int ticks) {
    Estimate<Real> e;
    for (int i = 0; i < ticks; ++i) {
      e = tick();
    }
    return e;
  }
};

template <typename Types>
class Silence : public ::testing::Test {};
using Scalars = ::testing::Types<Glide<DoubleEkf, double>, Glide<FloatEkf, float>, Glide<FixedEkf, float>>;
TYPED_TEST_SUITE(Silence, Scalars);

// Catches a refusal that continues while no pose comes: it would end COAST after 0.3 s.
TYPED_TEST(Silence, RefusesNothing) {
  TypeParam glide;
  glide.run(300);
  glide.off_m = 0.8;
  EXPECT_EQ(glide.run(2).refused_poses, 2U);
  glide.poses = false;
  const auto e = glide.run(40);
  EXPECT_EQ(e.refused_poses, 2U);
  EXPECT_EQ(e.refused_for, milliseconds(10)) << "from the first to the second";
}

// Catches ticks that are rounded one by one: 17 and 3 ms were predicted as 30 ms.
TYPED_TEST(Silence, IsPredictedForTheTimeThatHasPassedWhateverTheJitter) {
  TypeParam glide;
  glide.speed_m_s = 2.0;
  glide.run(500);
  glide.poses = false;
  for (int i = 0; i < 19; ++i) {
    glide.tick(milliseconds(17));
    glide.tick(milliseconds(3));
  }
  const auto e = glide.tick();
  EXPECT_NEAR(static_cast<double>(e.x.position_m), glide.x_m(), 0.03);  // 0.38 s: it was 0.38 m too far
}

// Catches a stall of which only the first 50 ms are predicted at once: the law then acts upon a place that lies behind.
TYPED_TEST(Silence, OfTheLoopItselfIsCaughtUpAtOnce) {
  this->RecordProperty("promise", "R16");
  for (const core::Duration stall : {milliseconds(30), milliseconds(150), milliseconds(470)}) {
    TypeParam glide;
    glide.speed_m_s = 2.0;
    glide.run(500);
    const std::uint32_t used = glide.filter.counters().poses_used;
    glide.poses = false;
    const auto e = glide.tick(stall);
    EXPECT_NEAR(static_cast<double>(e.x.position_m), glide.x_m(), 0.02) << stall.count();
    glide.poses = true;
    glide.run(1);
    glide.tick(stall);  // with a pose in the tick that catches up
    EXPECT_EQ(glide.filter.counters().poses_used, used + 2);
    EXPECT_EQ(glide.filter.counters().poses_refused, 0U);
  }
}

// A pilot flew for seconds without a pose, and the aircraft drifted by decimetres. Catches a first pose that is
// weighted with a covariance at its ceiling: half a metre became 1.6 m/s, and true poses were refused as lies.
TYPED_TEST(Silence, OfManySecondsEndsWithTheVelocityThatIs) {
  for (const double off_m : {0.2, 0.5, 1.0}) {
    TypeParam glide;
    glide.run(500);
    glide.poses = false;
    glide.run(430);
    glide.poses = true;
    glide.off_m = off_m;
    Estimate<decltype(glide.tick().x.position_m)> e;
    double fastest_m_s = 0.0;
    for (int tick = 0; tick < 60; ++tick) {
      e = glide.tick();
      fastest_m_s = std::max(fastest_m_s, std::abs(static_cast<double>(e.x.velocity_m_s)));
    }
    EXPECT_LT(fastest_m_s, 0.1) << off_m;
    EXPECT_NEAR(static_cast<double>(e.x.position_m), off_m, 0.01);
    EXPECT_EQ(e.refused_poses, 0U) << off_m;
  }
}

// Catches an observer that gives up at the first stale telemetry: the failsafe coasts from 100 to 500 ms.
TYPED_TEST(Silence, OfTelemetryIsPredictedThroughWhilePosesCome) {
  this->RecordProperty("promise", "R12");
  TypeParam glide;
  glide.rate_z_rad_s = 0.5;
  glide.run(300);
  glide.attitudes = false;
  glide.poses = false;
  const auto before = glide.run(1);
  EXPECT_NEAR(static_cast<double>(before.yaw_rate_rad_s), glide.rate_z_rad_s, 0.01);
  for (int tick = 2; tick <= 60; ++tick) {
    const auto e = glide.tick();
    EXPECT_EQ(e.prediction_valid, tick <= 45) << tick;
    EXPECT_LT(std::abs(static_cast<double>(e.yaw_rad - before.yaw_rad)), 0.06) << "a turn that nobody sees any more";
  }
}

// A refused attitude is not a missing one: nobody knows whether the attitude or the estimate is right.
TYPED_TEST(Silence, IsNotTakenForAnAttitudeThatIsRefused) {
  TypeParam glide;
  glide.run(300);
  glide.roll_rad = 1.3;
  EXPECT_TRUE(glide.run(9).prediction_valid);
  EXPECT_FALSE(glide.run(3).prediction_valid);
}

// Catches a limit of the accuracy that a sender may report: in fixed point it was 37 mm.
TYPED_TEST(Silence, APoseOfAFewDecimetresIsTakenForWhatItIs) {
  const auto moved_m = [](double off_m, double variance_m2) {
    TypeParam glide;
    glide.run(1000);
    glide.off_m = off_m;
    glide.variance_m2 = variance_m2;
    return static_cast<double>(glide.tick().x.position_m);
  };
  const double of_37_mm = moved_m(0.1, 0.037 * 0.037);
  EXPECT_GT(of_37_mm, 2e-5);
  EXPECT_LT(moved_m(0.1, 0.3 * 0.3), 0.03 * of_37_mm);
  TypeParam glide;
  glide.run(1000);
  glide.off_m = 0.5;  // 2.5 of its sigmas
  glide.variance_m2 = 0.2 * 0.2;
  EXPECT_EQ(glide.run(1).refused_poses, 0U);
}

// Two poses agree if they are at most 30 mm, and 6 m/s for the time between their captures, apart in space.
TEST(PoseAgreement, EndsBeyondNoiseAndTheLargestSpeed) {
  for (const double apart_m : {0.329, 0.331}) {
    PoseAgreement<double> row;
    core::Pose<double> pose;
    pose.set_captured_at(core::TimePoint{});
    EXPECT_FALSE(row.add(pose, core::TimePoint{})) << "there is none before it";
    row.since_last() = milliseconds(70);  // the second pose is 20 ms old
    pose.set_captured_at(core::TimePoint(milliseconds(50)));
    pose.position_w_m = core::Vector<double, 3>(2.0, -1.0, 2.0) * (apart_m / 3.0);
    EXPECT_EQ(row.add(pose, core::TimePoint(milliseconds(70))), apart_m < 0.33);
  }
}

}  // namespace
}  // namespace m100::est
