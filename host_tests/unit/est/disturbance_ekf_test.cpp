// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/disturbance_ekf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "firmware/core/tilt.h"
#include "host_tests/unit/est/observed_vehicle.h"
#include "host_tests/unit/est/scalars.h"

namespace m100::est {
namespace {

using std::chrono::milliseconds;

/// A vehicle that hovers in a wind, tilted against it, measured with noise of a fixed seed.
template <typename Real>
class Hover {
 public:
  double wind_x_m_s2 = 1.0;
  double trim_rad = 0.0;
  core::Vector<double, 3> position{1.0, -2.0, 1.5};
  core::Vector<double, 3> velocity = core::Vector<double, 3>::Zero();
  double yaw_rad = 0.5;
  core::Duration age = milliseconds(20);
  double time_sigma_s = 0.0;

  ctl::Command<Real> command() const {
    const core::Euler<double> wanted = attitude();
    return {.roll_rad = static_cast<Real>(wanted.roll_rad),
            .pitch_rad = static_cast<Real>(wanted.pitch_rad - trim_rad)};
  }
  Measurement<Real> measurement() {
    const core::Euler<double> tilted = attitude();
    Measurement<Real> m;
    m.attitude.is_new = true;
    m.attitude.roll_rad = static_cast<Real>(tilted.roll_rad + 0.003 * normal_(random_));
    m.attitude.pitch_rad = static_cast<Real>(tilted.pitch_rad + 0.003 * normal_(random_));
    m.pose.is_new = true;
    m.pose.set_captured_at(m.now - age);
    m.pose.time_sigma_s = static_cast<Real>(time_sigma_s);
    const double age_s = core::seconds<double>(age);
    for (int i = 0; i < 3; ++i) {
      m.pose.position_w_m[i] = static_cast<Real>(position[i] - velocity[i] * age_s + 0.002 * normal_(random_));
    }
    m.pose.yaw_rad = static_cast<Real>(yaw_rad + 0.002 * normal_(random_));
    position += 0.01 * velocity;
    return m;
  }

 private:
  core::Euler<double> attitude() const {
    return core::attitude_of<double>({.x_rad = -std::atan(wind_x_m_s2 / 9.8066), .y_rad = 0.0}, yaw_rad);
  }
  std::mt19937 random_{11};
  std::normal_distribution<double> normal_;
};

template <typename Ekf>
class AllScalars : public ::testing::Test {};
TYPED_TEST_SUITE(AllScalars, Scalars);

template <typename Filter, typename Real>
Estimate<Real> run(Filter& filter, Hover<Real>& hover, int ticks) {
  Estimate<Real> e;
  for (int i = 0; i < ticks; ++i) {
    e = filter.update(hover.measurement(), hover.command(), core::kTickPeriod);
  }
  return e;
}

TYPED_TEST(AllScalars, FindsStateWindAndTrim) {
  using Real = typename TypeParam::Real;
  typename TypeParam::Filter filter(vehicle());
  Hover<Real> hover;
  hover.yaw_rad = 0.0;
  hover.trim_rad = 0.03;
  hover.velocity.z() = 0.2;  // nobody commands it
  const Estimate<Real> e = run(filter, hover, 3000);
  EXPECT_TRUE(e.healthy);
  EXPECT_NEAR(e.x.position_m, Real(1.0), Real(0.003));
  EXPECT_NEAR(e.y.position_m, Real(-2.0), Real(0.003));
  EXPECT_NEAR(static_cast<double>(e.height_m), hover.position.z() - 0.01 * hover.velocity.z(), 0.003);
  EXPECT_NEAR(e.climb_m_s, Real(0.2), Real(0.02));
  EXPECT_NEAR(e.climb_offset_m_s, Real(0.2), Real(0.02));
  EXPECT_NEAR(e.x.velocity_m_s, Real(0), Real(0.05));
  EXPECT_NEAR(e.x.disturbance_m_s2, Real(1.0), Real(0.25));
  EXPECT_NEAR(e.y.disturbance_m_s2, Real(0), Real(0.25));
  EXPECT_NEAR(e.x.input_offset_rad, Real(0.03), Real(0.01));
  EXPECT_EQ(filter.counters().poses_refused, 0U);
}

// Catches a filter that takes an old pose for a current one: at 2 m/s and 75 ms the error is 15 cm.
TYPED_TEST(AllScalars, AnOldPoseIsPutWhereItBelongs) {
  using Real = typename TypeParam::Real;
  for (const int age_ms : {0, 10, 35, 75, 200}) {
    typename TypeParam::Filter filter(vehicle());
    Hover<Real> hover;
    hover.wind_x_m_s2 = 0.0;
    hover.velocity = {2.0, -1.0, 0.0};
    hover.age = milliseconds(age_ms);
    const Estimate<Real> e = run(filter, hover, 600);
    const core::Vector<double, 3> truth = hover.position - 0.01 * hover.velocity;  // of the last measurement
    EXPECT_NEAR(static_cast<double>(e.x.position_m), truth.x(), 0.012) << age_ms;
    EXPECT_NEAR(static_cast<double>(e.y.position_m), truth.y(), 0.012) << age_ms;
    EXPECT_EQ(e.pose_age, milliseconds(age_ms));
  }
}

// Catches a covariance that reaches the end of its range: the sigma was once halved 0.9 s into a gap, before the pose
// was given up, and the gains that followed were wrong.
TYPED_TEST(AllScalars, NoSigmaShrinksWhileNoPoseComes) {
  using Real = typename TypeParam::Real;
  typename TypeParam::Filter filter(vehicle());
  Hover<Real> hover;
  Estimate<Real> e = run(filter, hover, 1000);
  for (int tick = 1; tick <= 300; ++tick) {
    Measurement<Real> m = hover.measurement();
    m.pose.is_new = false;
    const Estimate<Real> before = e;
    e = filter.update(m, hover.command(), core::kTickPeriod);
    ASSERT_GT(e.x.filter_variance_m2, before.x.filter_variance_m2) << tick;
    ASSERT_GT(e.y.filter_variance_m2, before.y.filter_variance_m2) << tick;
  }
}

// Catches a pose variance for which the filter's own covariance reaches its end: the sigma was then halved again
// and again, the gain of the velocity changed its sign, and a flight with all its poses was estimated at 5 m/s instead
// of 1.6.
TYPED_TEST(AllScalars, PosesOfAnUnknownTimeLeaveHowItsErrorsGoTogether) {
  using Real = typename TypeParam::Real;
  typename TypeParam::Filter filter(vehicle());
  Hover<Real> hover;
  hover.velocity.x() = 3.0;
  hover.age = milliseconds(90);
  hover.time_sigma_s = 0.04;
  run(filter, hover, 200);
  const Estimate<Real> e = run(filter, hover, 500);
  EXPECT_NEAR(e.x.velocity_m_s, Real(3.0), Real(0.1));
  // The gate allows the full effect of the uncertain time on a pose: six times 0.12 m.
  const std::uint64_t refused = filter.counters().poses_refused;
  hover.position.x() += 0.5;
  run(filter, hover, 1);
  EXPECT_EQ(filter.counters().poses_refused, refused);
  hover.position.x() += 0.6;
  run(filter, hover, 1);
  EXPECT_EQ(filter.counters().poses_refused, refused + 1);
}

// Catches an observer that ignores the accuracy which the sender of a pose reports.
TYPED_TEST(AllScalars, APoseThatClaimsLittleMovesLittle) {
  using Real = typename TypeParam::Real;
  const auto moved_by_one_pose = [](Real sender_variance_m2) {
    typename TypeParam::Filter filter(vehicle());
    Hover<Real> hover;
    hover.wind_x_m_s2 = 0.0;
    const Estimate<Real> before = run(filter, hover, 1000);
    Measurement<Real> m = hover.measurement();
    m.pose.position_w_m.x() = before.x.position_m + Real(0.008);
    m.pose.position_variance_m2.setConstant(sender_variance_m2);
    const Estimate<Real> after = filter.update(m, hover.command(), core::kTickPeriod);
    return static_cast<double>(after.x.position_m - before.x.position_m);
  };
  const double unreported = moved_by_one_pose(Real(0));
  EXPECT_EQ(moved_by_one_pose(Real(1e-8)), unreported) << "the vehicle file's sigma is the least";
  EXPECT_EQ(moved_by_one_pose(std::numeric_limits<Real>::quiet_NaN()), unreported);
  EXPECT_GT(unreported, 2e-4);
  EXPECT_LT(std::abs(moved_by_one_pose(Real(0.01))), 0.1 * unreported);
}

TYPED_TEST(AllScalars, NumbersThatAreNoneAreDroppedCountedAndForgotten) {
  using Real = typename TypeParam::Real;
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  const Real infinity = std::numeric_limits<Real>::infinity();
  this->RecordProperty("promise", "R11");
  typename TypeParam::Filter filter(vehicle());
  Hover<Real> hover;
  run(filter, hover, 500);
  int sent = 0;
  for (const Real bad : {nan, infinity, -infinity}) {
    for (int field = 0; field < 9; ++field) {
      Measurement<Real> m = hover.measurement();
      ctl::Command<Real> command = hover.command();
      Real* const fields[] = {&m.pose.position_w_m[0],     &m.pose.position_w_m[2], &m.pose.yaw_rad,
                              &m.attitude.roll_rad,        &m.attitude.pitch_rad,   &m.attitude.rate_b_rad_s[0],
                              &m.attitude.rate_b_rad_s[2], &command.roll_rad,       &command.climb_m_s};
      *fields[field] = bad;
      const Estimate<Real> e = filter.update(m, command, core::kTickPeriod);
      ++sent;
      EXPECT_TRUE(std::isfinite(e.x.position_m) && std::isfinite(e.y.tilt_rad) && std::isfinite(e.height_m) &&
                  std::isfinite(e.yaw_rad))
          << field;
      EXPECT_NEAR(e.x.position_m, Real(1.0), Real(0.01));
    }
  }
  EXPECT_EQ(filter.counters().not_finite, static_cast<std::uint32_t>(sent));
  EXPECT_EQ(filter.counters().recoveries, 0U);
}

// The innovation gate: a single outlier in place or heading has no effect; twenty poses that agree are accepted, once,
// and the reason is reported.
TYPED_TEST(AllScalars, AJumpOfThePoseSourceIsRefusedThenBelieved) {
  using Real = typename TypeParam::Real;
  typename TypeParam::Filter filter(vehicle());
  Hover<Real> hover;
  run(filter, hover, 500);
  Measurement<Real> wild = hover.measurement();
  wild.pose.position_w_m[0] += Real(0.5);
  Estimate<Real> e = filter.update(wild, hover.command(), core::kTickPeriod);
  EXPECT_EQ(e.refused_poses, 1U);
  EXPECT_NEAR(e.refusal.distance_m, Real(0.5), Real(0.02));
  EXPECT_LT(e.refusal.allowed_m, e.refusal.distance_m);
  EXPECT_NEAR(e.x.position_m, Real(1.0), Real(0.01));
  wild = hover.measurement();
  wild.pose.yaw_rad += static_cast<Real>(core::kPi);
  e = filter.update(wild, hover.command(), core::kTickPeriod);
  EXPECT_EQ(e.refused_poses, 2U);
  EXPECT_NEAR(static_cast<double>(e.refusal.turned_rad), core::kPi, 0.02);
  EXPECT_NEAR(e.yaw_rad, Real(0.5), Real(0.01));
  e = run(filter, hover, 10);
  EXPECT_EQ(e.refused_poses, 0U);
  hover.position.x() += 0.8;
  e = run(filter, hover, 10);
  EXPECT_GE(e.refused_poses, 5U);
  EXPECT_NEAR(e.x.position_m, Real(1.0), Real(0.02));
  e = run(filter, hover, 100);
  EXPECT_EQ(e.refused_poses, 0U);
  EXPECT_NEAR(e.x.position_m, Real(1.8), Real(0.01));
  EXPECT_NEAR(e.x.disturbance_m_s2, Real(1.0), Real(0.4));
  EXPECT_EQ(filter.counters().recoveries, 1U);
  EXPECT_EQ(filter.counters().last_recovery, ResetReason::kPoseMoved);
}

TYPED_TEST(AllScalars, ComesBackAfterALongDropoutSomewhereElse) {
  using Real = typename TypeParam::Real;
  typename TypeParam::Filter filter(vehicle());
  Hover<Real> hover;
  run(filter, hover, 500);
  for (int i = 0; i < 150; ++i) {
    Measurement<Real> m = hover.measurement();
    m.pose.is_new = false;
    const Estimate<Real> e = filter.update(m, hover.command(), core::kTickPeriod);
    EXPECT_EQ(e.healthy, i < 100) << i;  // after a second without a pose it is no longer healthy
    EXPECT_EQ(e.pose_age, milliseconds(20 + 10 * (i + 1)));
  }
  hover.position += core::Vector<double, 3>{0.6, 0.3, 0.1};
  hover.velocity = {0.5, 0.0, 0.0};
  hover.time_sigma_s = 0.4;
  Estimate<Real> e;
  while (filter.counters().recoveries == 0) {
    e = run(filter, hover, 1);
  }
  EXPECT_GT(e.x.position_variance_m2, Real(0.02)) << "the time of this pose is uncertain: 0.2 m";
  e = run(filter, hover, 60);
  EXPECT_NEAR(static_cast<double>(e.x.position_m), hover.position.x(), 0.03);
  EXPECT_EQ(filter.counters().last_recovery, ResetReason::kLongDropout);
  EXPECT_EQ(filter.counters().recoveries, 1U);
}

TYPED_TEST(AllScalars, AttitudesInDegreesAreRefused) {
  using Real = typename TypeParam::Real;
  typename TypeParam::Filter filter(vehicle());
  Hover<Real> hover;
  run(filter, hover, 300);
  for (int i = 0; i < 5; ++i) {
    Measurement<Real> m = hover.measurement();
    m.attitude.pitch_rad *= Real(57.3);
    const Estimate<Real> e = filter.update(m, hover.command(), core::kTickPeriod);
    EXPECT_NEAR(e.x.tilt_rad, Real(-0.1016), Real(0.03));
  }
  EXPECT_EQ(filter.counters().attitudes_refused, 5U);
}

// Catches an age in the wrong unit at the start of the filter: at 2 m/s a pose that is 100 ms old is 0.2 m behind.
TYPED_TEST(AllScalars, StartsInFlightWhereItIsAndWithTheVelocityItHas) {
  using Real = typename TypeParam::Real;
  typename TypeParam::Filter filter(vehicle());
  Hover<Real> hover;
  hover.wind_x_m_s2 = 0.0;
  hover.velocity = {2.5, -2.0, 1.0};
  hover.age = milliseconds(100);
  hover.time_sigma_s = 0.4;
  Estimate<Real> e;
  for (int i = 0; i < 30 && filter.counters().poses_used == 0; ++i) {
    e = run(filter, hover, 1);
  }
  ASSERT_EQ(filter.counters().poses_used, 1U);
  const core::Vector<double, 3> truth = hover.position - 0.01 * hover.velocity;  // of the last measurement
  // Two poses with errors of 2 mm, 0.1 s apart, extrapolated by 0.1 s: 5 mm.
  EXPECT_NEAR(static_cast<double>(e.x.position_m), truth.x(), 0.02);
  EXPECT_NEAR(static_cast<double>(e.y.position_m), truth.y(), 0.02);
  EXPECT_NEAR(static_cast<double>(e.height_m), truth.z(), 0.02);
  EXPECT_GT(e.x.position_variance_m2, Real(0.9)) << "the time of this pose is uncertain: 1 m";
  e = run(filter, hover, 70);
  EXPECT_NEAR(e.x.velocity_m_s, Real(2.5), Real(0.15));
  EXPECT_NEAR(e.y.velocity_m_s, Real(-2.0), Real(0.15));
  EXPECT_NEAR(e.climb_m_s, Real(1.0), Real(0.15));
  EXPECT_EQ(filter.counters().poses_refused, 0U);
}

/// An axis that begins to turn: one tick under a large command.
AxisFilter<double> turning() {
  AxisModel model;
  model.attitude = vehicle().pitch;
  AxisFilter<double> filter(model);
  filter.predict({.now = 0.4, .before = 0.4, .after = 0.4});
  return filter;
}

// Catches a wrong sign of the rate that the axis has gained since the measurement: the gate is +-5 rad/s about the rate
// at the time of the measurement, and the axis has gained 3 rad/s since then.
TEST(RateGate, StandsAboutTheRateOfTheTimeOfTheMeasurement) {
  using Filter = AxisFilter<double>;
  const Filter before = turning();
  constexpr double kAge_s = 0.1;
  const double gained = kAge_s / kTick_s * before.state(Filter::kRate);  // from rest in one tick
  ASSERT_GT(gained, 2.0);
  const double rate_then = before.state(Filter::kRate) - gained;
  const double tilt_then = before.state(Filter::kTilt) - kAge_s * (before.state(Filter::kRate) - 0.5 * gained);
  for (const double side : {-1.0, 1.0}) {
    Filter inside = before;
    EXPECT_EQ(inside.fuse_attitude(tilt_then, rate_then + side * 4.9, kAge_s), FusionResult::kUsed) << side;
    Filter outside = before;
    EXPECT_EQ(outside.fuse_attitude(tilt_then, rate_then + side * 5.1, kAge_s), FusionResult::kRefused) << side;
  }
}

// Catches a gate that is centred on the negative of the rate.
TEST(RateGate, LetsAFastTurnPassAndNotItsOpposite) {
  using Filter = AxisFilter<double>;
  Filter filter = turning();
  for (int i = 0; i < 12; ++i) {
    filter.predict({.now = 0.65, .before = 0.65, .after = 0.65});
  }
  const double rate = filter.state(Filter::kRate);
  const double tilt = filter.state(Filter::kTilt);
  ASSERT_GT(rate, 2.6);
  EXPECT_EQ(Filter(filter).fuse_attitude(tilt, -rate, 0.0), FusionResult::kRefused);
  EXPECT_EQ(filter.fuse_attitude(tilt, rate, 0.0), FusionResult::kUsed);
}

}  // namespace
}  // namespace m100::est
