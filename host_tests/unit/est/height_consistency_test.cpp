// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/height_consistency.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace m100::est {
namespace {

constexpr double kStep_s = 0.01;

/// A hover in which the pose, the autopilot's height and its climb speed drift apart at the given speeds.
struct Drifts {
  double pose_m_s = 0.0;    ///< of the pose's error
  double height_m_s = 0.0;  ///< of the error of the autopilot's height
  double climb_m_s = 0.0;   ///< error of the autopilot's climb speed
};

class HeightConsistencyTest : public ::testing::Test {
 protected:
  /// @returns when it contradicts, in seconds; negative: never
  double fly(const Drifts& drifts, double seconds, double true_climb_m_s = 0.0) {
    for (double t_s = 0.0; t_s < seconds; t_s += kStep_s) {
      const double height_m = 1.5 + true_climb_m_s * t_s;
      Estimate<double> estimate;
      estimate.healthy = true;
      estimate.height_m = height_m + drifts.pose_m_s * t_s;
      ImuSample<double> imu;
      imu.climb_is_new = imu.height_is_new = true;
      imu.height_m = 3.0 + height_m + drifts.height_m_s * t_s;
      imu.climb_m_s = true_climb_m_s + drifts.climb_m_s;
      check_.update(imu, estimate, true, kStep_s);
      if (check_.contradicts()) {
        return t_s;
      }
    }
    return -1.0;
  }
  HeightConsistency<double> check_;
};

TEST_F(HeightConsistencyTest, ADriftIsNoticedBeforeItIsTwoMetres) {
  RecordProperty("promise", "R14, R18");
  for (const auto& [speed_m_s, within_s] : {std::pair{0.4, 5.0}, {0.07, 25.0}, {-0.07, 25.0}, {0.03, 65.0}}) {
    check_ = {};
    const double after_s = fly({.pose_m_s = speed_m_s}, 100.0);
    EXPECT_GT(after_s, 1.0) << speed_m_s;
    EXPECT_LT(after_s, within_s) << speed_m_s;
    EXPECT_NEAR(check_.allowed_m(), 0.84 * std::sqrt(std::max(1.0, after_s / 30.0)), 1e-6);
    EXPECT_EQ(check_.reads_high(), speed_m_s > 0.0);
    EXPECT_GT(std::abs(check_.drift_m()), check_.allowed_m());
    EXPECT_NEAR(check_.unexplained_drift_m(), check_.drift_m() - std::copysign(0.84, speed_m_s), 1e-9);
  }
}

// The height wanders by 0.84 m in 30 s at most, like a random walk; each channel of the autopilot alone may be wrong.
TEST_F(HeightConsistencyTest, AnHonestPoseIsNotContradicted) {
  RecordProperty("promise", "R17");
  EXPECT_LT(fly({.height_m_s = 0.84 / 30.0, .climb_m_s = 0.84 / 30.0}, 30.0), 0.0) << "both wander together";
  EXPECT_EQ(check_.unexplained_drift_m(), 0.0);
  check_ = {};
  EXPECT_LT(fly({.height_m_s = 0.5}, 100.0), 0.0) << "the barometer alone";
  EXPECT_EQ(check_.drift_m(), 0.0);
  check_ = {};
  EXPECT_LT(fly({.climb_m_s = 0.5}, 100.0), 0.0) << "the climb speed alone";
  check_ = {};
  EXPECT_LT(fly({.height_m_s = -0.5, .climb_m_s = 0.5}, 100.0), 0.0) << "against each other";
  check_ = {};
  EXPECT_LT(fly({}, 20.0, 1.0), 0.0) << "a climb";
  EXPECT_NEAR(check_.drift_m(), 0.0, 0.02);
}

TEST_F(HeightConsistencyTest, BeginsAnewWhenControlIsTaken) {
  RecordProperty("promise", "R17");
  ASSERT_GT(fly({.pose_m_s = 0.1}, 100.0), 0.0);
  check_.update({}, {}, false, kStep_s);
  EXPECT_FALSE(check_.contradicts());
  EXPECT_EQ(check_.drift_m(), 0.0);
  EXPECT_LT(fly({}, 20.0), 0.0);
}

TEST_F(HeightConsistencyTest, NumbersThatAreNoneLeaveNoTrace) {
  fly({.pose_m_s = std::nan("")}, 1.0);
  check_.update({}, {}, false, kStep_s);
  EXPECT_LT(fly({}, 20.0), 0.0);
  EXPECT_GT(fly({.pose_m_s = 0.1}, 100.0), 0.0);
}

// The weight grows by ratio - 1, beyond twice the allowed difference by its square, at most four a second.
TEST(Cusum, WeighsByTheSizeOfTheDisagreement) {
  const auto ticks_to = [](double ratio) {
    Cusum<double> cusum;
    int ticks = 0;
    for (; !cusum.exceeds_threshold() && ticks < 1000; ++ticks) {
      cusum.add(0.2 * ratio, 0.2, 0.001);
    }
    return ticks;
  };
  EXPECT_EQ(ticks_to(0.99), 1000);
  EXPECT_NEAR(ticks_to(1.8), 625, 1);
  EXPECT_NEAR(ticks_to(3.0), 187.5, 1);
  EXPECT_NEAR(ticks_to(99.0), 125, 1);
  Cusum<double> full;
  full.add(99.0, 1.0, 10.0);
  full.add(0.0, 1.0, 0.49);
  EXPECT_TRUE(full.exceeds_threshold());
  full.add(0.0, 1.0, 0.02);
  EXPECT_FALSE(full.exceeds_threshold());
}

}  // namespace
}  // namespace m100::est
