// SPDX-License-Identifier: BSD-3-Clause
// What becomes of a heading that the gate has refused (promise R14).
#include <algorithm>
#include <cmath>

#include "firmware/core/maths.h"
#include "host_tests/unit/est/observed_vehicle.h"
#include "host_tests/unit/est/scalars.h"

namespace m100::est {
namespace {

constexpr double kFlip_rad = 2.5;

/// A vehicle that hovers with heading 0.5 rad. The fields say what its two sources report beyond that.
template <typename Ekf>
class HeadingResetTest : public ::testing::Test {
 public:
  using Real = typename Ekf::Real;
  double pose_turned_rad = 0.0;
  double autopilot_turned_rad = 0.0;
  double gyro_rad_s = 0.0;
  double x_m = 1.0;
  HeadingReset allowed = HeadingReset::kFree;

  Estimate<Real> run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      now_ += core::kTickPeriod;
      Measurement<Real> m;
      m.now = now_;
      m.attitude.is_new = true;
      m.attitude.rate_b_rad_s.z() = static_cast<Real>(gyro_rad_s);
      m.attitude.yaw_rad = core::wrap_pi(static_cast<Real>(-1.0 + autopilot_turned_rad));
      m.pose.is_new = true;
      m.pose.set_captured_at(now_ - std::chrono::milliseconds(20));
      m.pose.position_w_m = {static_cast<Real>(x_m), Real(-2), Real(1.5)};
      m.pose.yaw_rad = static_cast<Real>(0.5 + pose_turned_rad);
      filter_.update(m, {}, core::kTickPeriod, allowed);
    }
    return filter_.estimate();
  }
  double turned_rad() const { return std::abs(core::wrap_pi(static_cast<double>(filter_.estimate().yaw_rad) - 0.5)); }
  const typename Ekf::Filter& filter() const { return filter_; }

 private:
  core::TimePoint now_{};
  typename Ekf::Filter filter_{vehicle()};
};
TYPED_TEST_SUITE(HeadingResetTest, Scalars);

// Catches an observer that adopts the heading with the position while the aircraft brakes by it.
TYPED_TEST(HeadingResetTest, IsNeverMadeWhileTheFlightEndsAndThePositionIs) {
  this->RecordProperty("promise", "R14");
  this->run(300);
  this->allowed = HeadingReset::kNever;
  this->pose_turned_rad = this->autopilot_turned_rad = kFlip_rad;
  this->x_m = 2.0;
  double moved_m = 0.0;
  for (int tick = 0; tick < 1000; ++tick) {
    moved_m = std::max(moved_m, static_cast<double>(this->run(1).x.position_m));
    ASSERT_LT(this->turned_rad(), 0.05) << tick;
  }
  EXPECT_NEAR(moved_m, 2.0, 0.05);
  this->allowed = HeadingReset::kFree;
  this->run(200);
  EXPECT_NEAR(this->turned_rad(), kFlip_rad, 0.05) << "the pilot has control";
}

TYPED_TEST(HeadingResetTest, NeedsTheAutopilotsConfirmationInFlight) {
  this->RecordProperty("promise", "R14");
  for (const double reported_rad : {0.0, 0.7 * kFlip_rad, -kFlip_rad}) {
    this->allowed = HeadingReset::kFree;
    this->pose_turned_rad = this->autopilot_turned_rad = 0.0;
    this->run(500);
    this->allowed = HeadingReset::kConfirmed;
    this->pose_turned_rad = kFlip_rad;
    this->autopilot_turned_rad = reported_rad;
    this->run(300);
    EXPECT_LT(this->turned_rad(), 0.05) << reported_rad;
  }
}

// A turn that neither poses nor gyroscopes showed. The failsafe counts poses as lost when they were refused for 0.3 s.
TYPED_TEST(HeadingResetTest, FollowsATurnThatTheAutopilotShowsToo) {
  this->RecordProperty("promise", "R17");
  this->run(300);
  this->allowed = HeadingReset::kConfirmed;
  this->pose_turned_rad = kFlip_rad;
  this->autopilot_turned_rad = kFlip_rad - 0.1;
  const Estimate<typename TypeParam::Real> before = this->run(30);
  EXPECT_LT(this->turned_rad(), 0.05);
  EXPECT_LT(before.refused_for, std::chrono::milliseconds(300));
  EXPECT_EQ(this->run(1).refused_poses, 0U);
  EXPECT_NEAR(this->turned_rad(), kFlip_rad, 0.05);
  EXPECT_EQ(this->filter().counters().recoveries, 0U) << "the position stays that of the filter";
}

TYPED_TEST(HeadingResetTest, IsNotConfirmedByPosesThatLeaveThePrediction) {
  this->RecordProperty("promise", "R14");
  this->run(300);
  this->allowed = HeadingReset::kConfirmed;
  this->pose_turned_rad = this->autopilot_turned_rad = kFlip_rad;
  this->x_m = 3.0;
  this->run(45);
  EXPECT_LT(this->turned_rad(), 0.05);
}

// Catches gyroscopes that turn the estimate away from both other headings, after which the aircraft brakes sideways.
TYPED_TEST(HeadingResetTest, GyroscopesThatBothHeadingsContradictDoNotTurnTheEstimate) {
  this->RecordProperty("promise", "R14");
  this->run(300);
  this->allowed = HeadingReset::kNever;
  for (int tick = 0; tick < 1000; ++tick) {
    this->gyro_rad_s = std::min(0.01 * tick, 5.0);
    this->run(1);
    ASSERT_LT(this->turned_rad(), 0.35) << tick;
  }
}

TYPED_TEST(HeadingResetTest, AnAutopilotThatTurnsAloneDoesNotTurnTheEstimate) {
  this->RecordProperty("promise", "R14");
  this->run(300);
  for (int tick = 0; tick < 1000; ++tick) {
    this->autopilot_turned_rad = 0.01 * tick;
    this->run(1);
    ASSERT_LT(this->turned_rad(), 0.05) << tick;
  }
}

}  // namespace
}  // namespace m100::est
