// SPDX-License-Identifier: BSD-3-Clause
// Estimation of the pose latency from a known motion: each rule on its own. Flights with a complete pose source are in
// the property tests.
#include "firmware/est/timing/pose_latency.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

namespace m100::est {
namespace {

using std::chrono::milliseconds;
constexpr double kTurn_s = 2.0;  ///< of a circle of 0.15 m: 1.5 m/s^2

template <typename T>
struct PoseLatencyTest : ::testing::Test {
  using Vector2 = core::Vector<T, 2>;
  PoseLatency<T> latency;
  core::TimePoint now{};

  static Vector2 circle(double t_s, double size) {
    const double w = 2.0 * 3.14159265358979 / kTurn_s;
    return Vector2(static_cast<T>(size * std::cos(w * t_s)), static_cast<T>(size * std::sin(w * t_s)));
  }
  /// Flies a circle. The poses are older than their capture times by `late_s`, and a steady push that no sensor reports
  /// displaces the position.
  void fly(double length_s, double late_s, double radius_m = 0.15, T disturbance_acceleration_m_s2 = T(0)) {
    const double w = 2.0 * 3.14159265358979 / kTurn_s;
    for (int k = 0; k < static_cast<int>(length_s * 100.0); ++k) {
      now += milliseconds(10);
      const double t_s = core::seconds<double>(now.time_since_epoch());
      const double then_s = t_s - late_s;
      latency.add_acceleration(now, circle(t_s, -radius_m * w * w));
      const T aside = static_cast<T>(0.5 * then_s * then_s) * disturbance_acceleration_m_s2;
      latency.add_pose(now, circle(then_s, radius_m) + Vector2(aside, T(0)));
    }
  }
};
using BothReals = ::testing::Types<float, double>;
TYPED_TEST_SUITE(PoseLatencyTest, BothReals);

// Tolerance 3 ms: an integral that is cut at the wrong place is off by a third of a tick of 10 ms.
TYPED_TEST(PoseLatencyTest, IsFoundInMotionWhateverWasBelieved) {
  for (const double late_s : {0.03, 0.06, 0.15}) {
    for (const double believed_s : {0.0, 0.02, 0.1}) {
      this->latency = {};
      this->latency.set_prior(static_cast<TypeParam>(believed_s), TypeParam(0.02));
      this->fly(20.0, late_s);
      EXPECT_NEAR(this->latency.tau_s(), late_s, 0.003) << "believed " << believed_s;
      EXPECT_TRUE(this->latency.is_observable());
    }
  }
}

TYPED_TEST(PoseLatencyTest, ASteadyPushThatNobodySeesIsNoLatency) {
  this->latency.set_prior(TypeParam(0.02), TypeParam(0.02));
  this->fly(20.0, 0.06, 0.15, TypeParam(0.01));
  EXPECT_NEAR(this->latency.tau_s(), 0.06, 0.003);
}

// A still hover gives no information: the belief stays, with its uncertainty.
TYPED_TEST(PoseLatencyTest, WithoutMotionTheBeliefStays) {
  this->latency.set_prior(TypeParam(0.04), TypeParam(0.03));
  EXPECT_FALSE(this->latency.is_observable());
  this->fly(20.0, 0.1, 0.0);
  EXPECT_EQ(this->latency.tau_s(), TypeParam(0.04));
  EXPECT_NEAR(this->latency.sigma_s(), 0.03, 1e-6);
  EXPECT_FALSE(this->latency.is_observable());
}

// A pose cannot arrive before its capture, and poses older than 250 ms are not used for flight (R3).
TYPED_TEST(PoseLatencyTest, IsFromNoughtTo250Milliseconds) {
  this->latency.set_prior(TypeParam(0.4), TypeParam(0.001));
  EXPECT_EQ(this->latency.tau_s(), TypeParam(0.25));
  this->latency.set_prior(TypeParam(-0.1), TypeParam(0.001));
  EXPECT_EQ(this->latency.tau_s(), TypeParam(0));
  this->latency.set_prior(TypeParam(0.25), TypeParam(0.001));
  EXPECT_EQ(this->latency.tau_s(), TypeParam(0.25));
}

// Poses return after a gap, or after something other than flight has moved them: a window must not span the
// interruption.
TYPED_TEST(PoseLatencyTest, AWindowThatWasInterruptedIsLeftOut) {
  this->latency.set_prior(TypeParam(0.02), TypeParam(0.02));
  this->fly(20.0, 0.06);
  const TypeParam before = this->latency.tau_s();
  for (int jump = 0; jump < 20; ++jump) {
    this->fly(0.5, 0.06);
    this->latency.interrupt();
    this->now += std::chrono::seconds(3);
  }
  EXPECT_NEAR(this->latency.tau_s(), before, 0.001);
}

}  // namespace
}  // namespace m100::est
