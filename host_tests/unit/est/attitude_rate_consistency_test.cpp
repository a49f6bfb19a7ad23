// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/attitude_rate_consistency.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <utility>

namespace m100::est {
namespace {

constexpr double kTick_s = 0.01;

class AttitudeRateConsistencyTest : public ::testing::Test {
 protected:
  AttitudeRateConsistencyTest() { imu_.attitude_is_new = true; }

  AttitudeRateConsistency<double> check_;
  ImuSample<double> imu_;
};

/// Tilts as in a hover, by a quarter of a degree.
void lean(ImuSample<double>& imu, double t_s, double amplitude_rad = 0.0045) {
  imu.roll_rad = amplitude_rad * std::sin(2.0 * t_s);
  imu.pitch_rad = amplitude_rad * std::cos(1.7 * t_s);
  imu.rate_b_rad_s = {2.0 * amplitude_rad * std::cos(2.0 * t_s), -1.7 * amplitude_rad * std::sin(1.7 * t_s), 0.0};
}

TEST_F(AttitudeRateConsistencyTest, IsSilentWhileTheRatesMakeTheTilt) {
  RecordProperty("promise", "R17");
  for (const double amplitude_rad : {0.0045, 0.3}) {
    check_ = AttitudeRateConsistency<double>();
    for (double t_s = 0.0; t_s < 20.0; t_s += kTick_s) {
      // Rates that are 20 ms old and 5 % wrong, and an attitude that is corrected by a degree.
      lean(imu_, t_s - 0.02, amplitude_rad);
      const core::Vector<double, 3> rates = 1.05 * imu_.rate_b_rad_s;
      lean(imu_, t_s, amplitude_rad);
      imu_.rate_b_rad_s = rates;
      imu_.roll_rad += 0.0087 * std::sin(0.3 * t_s);
      check_.update(imu_, kTick_s);
      ASSERT_FALSE(check_.contradicts()) << amplitude_rad << " rad, " << t_s << " s";
    }
  }
}

TEST_F(AttitudeRateConsistencyTest, NamesAnAttitudeThatDoesNotFollowItsRatesBeforeAnyPoseCame) {
  RecordProperty("promise", "R14");
  const std::array lies{
      +[](ImuSample<double>& imu) { imu.roll_rad = imu.pitch_rad = 0.0; },
      +[](ImuSample<double>& imu) { std::swap(imu.roll_rad, imu.pitch_rad); },
      +[](ImuSample<double>& imu) { imu.rate_b_rad_s *= 57.3; },
      +[](ImuSample<double>& imu) { imu.rate_b_rad_s.setZero(); },
      +[](ImuSample<double>& imu) { imu.roll_rad *= -1.0; },
  };
  for (std::size_t lie = 0; lie < lies.size(); ++lie) {
    check_ = AttitudeRateConsistency<double>();
    double t_s = 0.0;
    for (; t_s < 3.0 && !check_.contradicts(); t_s += kTick_s) {
      lean(imu_, t_s, 0.02);
      lies.at(lie)(imu_);
      check_.update(imu_, kTick_s);
    }
    EXPECT_TRUE(check_.contradicts()) << "lie " << lie;
  }
}

// The worst fault of the rates that fault_search found once flew 1.4 m unnoticed because of its own noise: 3 rad/s of
// noise were taken for turns so fast that a delay of 80 ms was within the limit.
TEST_F(AttitudeRateConsistencyTest, RatesThatScatterExcuseNoDelay) {
  RecordProperty("promise", "R14");
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 3.0);
  double t_s = 0.0;
  for (; t_s < 10.0 && !check_.contradicts(); t_s += kTick_s) {
    lean(imu_, t_s - 0.08, 0.1);
    const core::Vector<double, 3> rates = imu_.rate_b_rad_s;
    lean(imu_, t_s, 0.1);
    imu_.rate_b_rad_s = rates + core::Vector<double, 3>(0.3 * noise(random), 0.9 * noise(random), 0.0);
    check_.update(imu_, kTick_s);
  }
  EXPECT_LT(t_s, 1.0);
}

TEST_F(AttitudeRateConsistencyTest, NoiseOfAnHonestRateIsSilent) {
  RecordProperty("promise", "R17");
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0.0, 1.0);
  for (double t_s = 0.0; t_s < 200.0; t_s += kTick_s) {
    lean(imu_, t_s, 0.1);
    imu_.roll_rad += 5e-4 * noise(random);  // several times the noise of both measured logs
    imu_.rate_b_rad_s += core::Vector<double, 3>(0.02 * noise(random), 0.02 * noise(random), 0.0);
    check_.update(imu_, kTick_s);
    ASSERT_FALSE(check_.contradicts()) << t_s << " s";
  }
}

// In the turns of a step an offset of 4 degrees was within what a delay of the rates may explain, and the pose was
// called false instead: the aircraft was handed over at 2.4 m/s, 0.8 m beyond its fence.
TEST_F(AttitudeRateConsistencyTest, AJumpWithoutARateIsNamedWhileTheAircraftTurns) {
  RecordProperty("promise", "R14");
  for (const double offset_rad : {0.07, -0.07}) {
    check_ = AttitudeRateConsistency<double>();
    for (double t_s = 0.0; t_s < 10.2; t_s += kTick_s) {
      lean(imu_, 3.0 * t_s - 0.02, 0.3);
      const core::Vector<double, 3> rates = 3.0 * imu_.rate_b_rad_s;
      lean(imu_, 3.0 * t_s, 0.3);
      imu_.rate_b_rad_s = rates;
      const bool glitch = t_s > 5.0 && t_s < 5.05;  // it jumps back
      imu_.roll_rad += glitch || t_s > 10.0 ? offset_rad : 0.0;
      check_.update(imu_, kTick_s);
      ASSERT_TRUE(t_s > 10.0 || !check_.contradicts()) << t_s << " s";
    }
    EXPECT_TRUE(check_.contradicts()) << offset_rad;
  }
}

TEST_F(AttitudeRateConsistencyTest, AnAttitudeThatCameNotForAWhileIsNoEvidence) {
  for (double t_s = 0.0; t_s < 10.0; t_s += kTick_s) {
    lean(imu_, t_s, 0.3);
    imu_.attitude_is_new = std::fmod(t_s, 1.0) < 0.5;
    check_.update(imu_, kTick_s);
    ASSERT_FALSE(check_.contradicts()) << t_s << " s";
  }
}

// A burst after a gap is read in two ticks: between them the tilt changes by the motion of the whole gap.
TEST_F(AttitudeRateConsistencyTest, AnAttitudeThatIsOldByTheAutopilotsClockIsNoEvidence) {
  double age_s = 0.3;
  for (double t_s = 0.0; t_s < 10.0; t_s += kTick_s) {
    const double before_s = std::exchange(age_s, std::fmod(t_s, 1.0) < 0.5 * kTick_s ? 0.3 : 0.0);
    lean(imu_, t_s - age_s, 0.3);
    imu_.since_last_s = kTick_s + before_s - age_s;
    check_.update(imu_, kTick_s);
    ASSERT_FALSE(check_.contradicts()) << t_s << " s";
  }
}

}  // namespace
}  // namespace m100::est
