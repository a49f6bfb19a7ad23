// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/monitor/limit_cycle_detector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "firmware/core/maths.h"

namespace m100::ctl {
namespace {

constexpr double kStep_s = 0.01;
constexpr double kGravity_m_s2 = 9.81;

/// A motion along y: the tilt and an additional push [m/s^2]; the position follows from them.
struct Motion {
  std::function<double(double t_s)> tilt_rad = [](double) { return 0.0; };
  std::function<double(double t_s)> disturbance_acceleration_m_s2 = [](double) { return 0.0; };
  std::function<ref::AxisReference<double>(double t_s)> reference = [](double) { return ref::AxisReference<double>{}; };
  std::function<double(double t_s)> observed_m_s2 = [](double) { return 0.0; };  ///< the observer's disturbance
};

std::function<double(double)> sine(double height, double hz, double from_s = 0.0) {
  return
      [=](double t_s) { return t_s < from_s ? 0.0 : 0.5 * height * std::sin(2.0 * core::kPi * hz * (t_s - from_s)); };
}

/// @returns when the watch reports an oscillation [s]; negative: not within half a minute.
template <typename T = double>
double speaks_at(const Motion& motion, LimitCycleReport<T>* seen = nullptr) {
  LimitCycleDetector<T> watch;
  double position_m = 0.0;
  double velocity_m_s = 0.0;
  for (double t_s = 0.0; t_s < 30.0; t_s += kStep_s) {
    velocity_m_s += kStep_s * (motion.disturbance_acceleration_m_s2(t_s) - kGravity_m_s2 * motion.tilt_rad(t_s));
    position_m += kStep_s * velocity_m_s;
    est::Estimate<T> estimate;
    estimate.y.position_m = static_cast<T>(position_m);
    estimate.y.tilt_rad = static_cast<T>(motion.tilt_rad(t_s));
    estimate.y.disturbance_m_s2 = static_cast<T>(motion.observed_m_s2(t_s));
    const ref::AxisReference<double> wanted = motion.reference(t_s);
    ref::Window<T> window;
    window.y[0] = {.position_m = static_cast<T>(wanted.position_m),
                   .velocity_m_s = static_cast<T>(wanted.velocity_m_s),
                   .acceleration_m_s2 = static_cast<T>(wanted.acceleration_m_s2)};
    watch.update(estimate, window, true, static_cast<T>(kStep_s));
    if (watch.report().detected) {
      if (seen != nullptr) {
        *seen = watch.report();
      }
      return t_s;
    }
  }
  return -1.0;
}

class OscillationAt : public ::testing::TestWithParam<double> {};

// At the frequencies at which a loop of such an aircraft oscillates, the watch must report within three seconds, with
// the right height and frequency.
TEST_P(OscillationAt, IsNoticedWithinThreeSeconds) {
  RecordProperty("promise", "R17");
  LimitCycleReport<double> seen;
  const double at_s = speaks_at({.tilt_rad = sine(0.3, GetParam(), 5.0)}, &seen);
  EXPECT_NEAR(at_s, 5.0 + 5.5 * 0.5 / GetParam(), 0.2 / GetParam()) << "five half-waves and the turn that ends them";
  EXPECT_NEAR(seen.height_rad, 0.3, 0.02);
  EXPECT_NEAR(seen.frequency_hz, GetParam(), 0.1 * GetParam());
  EXPECT_NEAR(speaks_at<float>({.tilt_rad = sine(0.3, GetParam(), 5.0)}), at_s, 0.05);
}
INSTANTIATE_TEST_SUITE_P(LimitCycleDetector, OscillationAt, ::testing::Values(1.0, 1.3, 1.7, 2.5),
                         [](const auto& tested) { return std::to_string(static_cast<int>(10.0 * tested.param)); });

// A slower oscillation takes the same number of half-waves, and so more time; below 0.3 Hz it is not an oscillation of
// the loop.
TEST(LimitCycleDetector, CountsHalfWaves) {
  EXPECT_GT(speaks_at({.tilt_rad = sine(0.3, 0.5)}), 4.0);
  EXPECT_LT(speaks_at({.tilt_rad = sine(0.3, 0.5)}), 7.0);
  EXPECT_GT(speaks_at({.tilt_rad = sine(0.3, 0.33)}), 0.0);
  EXPECT_LT(speaks_at({.tilt_rad = sine(0.3, 0.27)}), 0.0);
  EXPECT_GT(speaks_at({.tilt_rad = sine(0.3, 2.8)}), 0.0);
  EXPECT_LT(speaks_at({.tilt_rad = sine(0.3, 3.3)}), 0.0);
  EXPECT_GT(speaks_at({.tilt_rad = sine(0.12, 1.3)}), 0.0);
  EXPECT_LT(speaks_at({.tilt_rad = sine(0.095, 1.3)}), 0.0) << "a restless hover";
}

TEST(LimitCycleDetector, NoticesASwingThatGrows) {
  const auto grows = [](double t_s) { return 0.002 * std::exp(0.8 * t_s) * std::sin(2.0 * core::kPi * 1.3 * t_s); };
  const double at_s = speaks_at({.tilt_rad = grows});
  EXPECT_GT(at_s, 3.0);
  EXPECT_LT(at_s, 8.0);
}

// The response to a step or a push dies out, if slowly where the loop has little damping left.
TEST(LimitCycleDetector, IsSilentWhereAMotionDiesOut) {
  for (const double rate_per_s : {1.2, 0.6, 0.3}) {
    const auto rings = [=](double t_s) {
      return t_s < 2.0 ? 0.0 : 0.4 * std::exp(-rate_per_s * (t_s - 2.0)) * std::sin(2.0 * core::kPi * (t_s - 2.0));
    };
    EXPECT_LT(speaks_at({.tilt_rad = rings}), 0.0) << rate_per_s;
  }
}

// Air that pushes as regularly as an oscillation, answered late and 50 % too strongly: |T| = 1.5.
TEST(LimitCycleDetector, IsSilentWhereTheAirPushes) {
  RecordProperty("promise", "R17");
  for (const double hz : {0.4, 0.7, 1.0, 1.5}) {
    const auto push = [=](double t_s) { return 2.0 * std::sin(2.0 * core::kPi * hz * t_s); };
    const auto answer = [=](double t_s) { return 1.5 / kGravity_m_s2 * push(t_s - 0.15); };
    EXPECT_LT(speaks_at({.tilt_rad = answer, .disturbance_acceleration_m_s2 = push}), 0.0) << hz;
  }
}

// Both sides of the bound: the air explains three tenths less, or more, than a kMinRatio-th of the tilt, as the motion
// shows it or as the observer estimates it.
TEST(LimitCycleDetector, NoticesASwingBeyondWhatTheAirExplains) {
  for (const double hz : {0.5, 1.0, 2.0}) {
    for (const double share : {0.4, 1.5}) {
      const auto air = sine(share * 0.5 * kGravity_m_s2 / LimitCycleDetector<double>::kMinRatio, hz);
      const Motion pushed{.tilt_rad = sine(0.5, hz), .disturbance_acceleration_m_s2 = air};
      EXPECT_EQ(speaks_at(pushed) > 0.0, share < 1.0) << hz;
      EXPECT_EQ(speaks_at({.tilt_rad = sine(0.5, hz), .observed_m_s2 = air}) > 0.0, share < 1.0) << hz;
    }
  }
}

/// One axis of a circle.
ref::AxisReference<double> swinging_reference(double t_s, double size_m, double hz) {
  const double w = 2.0 * core::kPi * hz;
  return {.position_m = size_m * std::sin(w * t_s),
          .velocity_m_s = size_m * w * std::cos(w * t_s),
          .acceleration_m_s2 = -size_m * w * w * std::sin(w * t_s)};
}

// A course that oscillates, flown by an aircraft whose gain is 30 % higher than believed; and goals that alternate.
TEST(LimitCycleDetector, IsSilentWhereTheReferenceAsksForIt) {
  RecordProperty("promise", "R17");
  const auto course = [](double t_s) { return swinging_reference(t_s, 0.5, 0.5); };
  const auto follows = [=](double t_s) { return -1.3 * course(t_s).acceleration_m_s2 / kGravity_m_s2; };
  EXPECT_LT(speaks_at({.tilt_rad = follows, .reference = course}), 0.0);
  const auto goals = [](double t_s) {
    return ref::AxisReference<double>{.position_m = std::fmod(t_s, 2.0) < 1.0 ? 0.0 : 0.5};
  };
  EXPECT_LT(speaks_at({.tilt_rad = sine(0.4, 1.0), .reference = goals}), 0.0);
}

TEST(LimitCycleDetector, LooksAwayAndBeginsAnew) {
  LimitCycleDetector<double> watch;
  const auto watch_for = [&](double time_s, bool flies, double step_s) {
    for (double t_s = 0.0; t_s < time_s; t_s += step_s) {
      est::Estimate<double> estimate;
      const double w = 2.0 * core::kPi * 1.3;
      estimate.x.tilt_rad = 0.2 * std::sin(w * t_s);
      estimate.x.position_m = -kGravity_m_s2 * 0.2 / (w * w) * std::sin(w * t_s);
      watch.update(estimate, {}, flies, step_s);
    }
    return watch.report().detected;
  };
  EXPECT_TRUE(watch_for(4.0, true, kStep_s));
  watch.pause(2.0);
  EXPECT_FALSE(watch.report().detected);
  EXPECT_FALSE(watch_for(3.5, true, kStep_s));
  EXPECT_TRUE(watch_for(4.0, true, kStep_s)) << "two seconds later it counts again";
  EXPECT_FALSE(watch_for(0.1, false, kStep_s)) << "the law does not fly";
  EXPECT_FALSE(watch_for(4.0, true, 0.03)) << "ticks that stall";
}

// Catches a watch that does not remember that one swing has been noticed, or never forgets it: after a pause fewer
// half-waves are enough for as long as the law flies.
TEST(LimitCycleDetector, AfterAPauseFewerHalfWavesAreEnoughUntilTheLawStopsFlying) {
  constexpr double kHalfWave_s = 0.5 / 1.3;
  LimitCycleDetector<double> watch;
  double t_s = 0.0;
  const auto tick = [&](bool flies) {
    est::Estimate<double> estimate;
    const double w = 2.0 * core::kPi * 1.3;
    estimate.x.tilt_rad = 0.2 * std::sin(w * t_s);
    estimate.x.position_m = -kGravity_m_s2 * 0.2 / (w * w) * std::sin(w * t_s);
    watch.update(estimate, {}, flies, kStep_s);
    t_s += kStep_s;
  };
  const auto time_to_notice_s = [&] {
    const double begin_s = t_s;
    while (!watch.report().detected) {
      tick(true);
      if (t_s > begin_s + 20.0) {
        return -1.0;
      }
    }
    return t_s - begin_s;
  };
  const double first_s = time_to_notice_s();
  EXPECT_GT(first_s, LimitCycleDetector<double>::kHalfWaves * kHalfWave_s);
  watch.pause(0.0);
  const double again_s = time_to_notice_s();
  EXPECT_GT(again_s, 0.0);
  // Two half-waves fewer, and the first one need not begin at rest.
  EXPECT_LT(again_s, LimitCycleDetector<double>::kHalfWaves * kHalfWave_s);
  watch.pause(0.0);
  tick(false);
  const double anew_s = time_to_notice_s();
  EXPECT_GT(anew_s, LimitCycleDetector<double>::kHalfWaves * kHalfWave_s);
}

TEST(LimitCycleDetector, ReportsTheHigherOfTwoSwingsWithItsOwnFrequency) {
  for (const bool higher_in_x : {true, false}) {
    LimitCycleDetector<double> watch;
    for (double t_s = 0.0; t_s < 6.0; t_s += kStep_s) {
      const auto set = [&](est::AxisEstimate<double>& axis, double sign, double height, double hz) {
        const double w = 2.0 * core::kPi * hz;
        axis.tilt_rad = 0.5 * height * std::sin(w * t_s);
        axis.position_m = -sign * kGravity_m_s2 * axis.tilt_rad / (w * w);
      };
      est::Estimate<double> estimate;
      set(estimate.x, 1.0, higher_in_x ? 0.4 : 0.3, 1.0);
      set(estimate.y, -1.0, higher_in_x ? 0.3 : 0.4, 1.6);
      watch.update(estimate, {}, true, kStep_s);
    }
    ASSERT_TRUE(watch.report().detected);
    EXPECT_NEAR(watch.report().height_rad, 0.4, 0.03);
    EXPECT_NEAR(watch.report().frequency_hz, higher_in_x ? 1.0 : 1.6, 0.1);
  }
}

}  // namespace
}  // namespace m100::ctl
