// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/ctl/monitor/limit_cycle_detector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "firmware/core/maths.h"
#include "firmware/ctl/monitor/limit_cycle_response.h"
#include "firmware/mpc/generated/gain_table.h"

namespace m100::ctl {
namespace {

constexpr double kStep_s = 0.01;
constexpr double kGravity_m_s2 = 9.81;

/// A motion along y, and mirrored along x: the tilt and an additional push [m/s^2]; the position follows from them.
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

/// Along x, of an aircraft that swings as its tilt makes it, from peak to peak of the tilt.
est::Estimate<double> swinging(double height_rad, double hz, double t_s) {
  est::Estimate<double> estimate;
  estimate.x.tilt_rad = sine(height_rad, hz)(t_s);
  estimate.x.position_m = -kGravity_m_s2 * estimate.x.tilt_rad / std::pow(2.0 * core::kPi * hz, 2.0);
  return estimate;
}

/// @returns when the watch reports an oscillation [s]; negative: not within half a minute.
template <typename T = double>
double speaks_at(const Motion& motion, LimitCycleReport<T>* seen = nullptr) {
  LimitCycleDetector<T> watch, mirrored;
  double position_m = 9.0;
  double velocity_m_s = 0.0;
  for (double t_s = 0.0; t_s < 30.0; t_s += kStep_s) {
    velocity_m_s += kStep_s * (motion.disturbance_acceleration_m_s2(t_s) - kGravity_m_s2 * motion.tilt_rad(t_s));
    position_m += kStep_s * velocity_m_s;
    const est::AxisEstimate<T> axis{.position_m = static_cast<T>(position_m),
                                    .tilt_rad = static_cast<T>(motion.tilt_rad(t_s)),
                                    .disturbance_m_s2 = static_cast<T>(motion.observed_m_s2(t_s))};
    est::Estimate<T> along_x, along_y;
    along_x.x = along_y.y = axis;
    along_x.x.tilt_rad = -axis.tilt_rad;
    const ref::AxisReference<double> wanted = motion.reference(t_s);
    ref::Window<T> course_x, course_y;
    course_x.x[0] = course_y.y[0] = {static_cast<T>(wanted.position_m), static_cast<T>(wanted.velocity_m_s),
                                     static_cast<T>(wanted.acceleration_m_s2)};
    watch.update(along_y, course_y, true, static_cast<T>(kStep_s));
    mirrored.update(along_x, course_x, true, static_cast<T>(kStep_s));
    EXPECT_EQ(mirrored.report().detected, watch.report().detected) << t_s;
    if (watch.report().detected) {
      if (seen != nullptr) {
        *seen = watch.report();
      }
      return t_s;
    }
  }
  return -1.0;
}

// At the frequencies at which a loop of such an aircraft oscillates, the watch must report after five half-waves, which
// begin at the first crest, and a third of the next one, in which the tilt comes back by a quarter.
TEST(LimitCycleDetector, NoticesAnOscillationAfterFiveHalfWaves) {
  RecordProperty("promise", "R17");
  for (const double hz : {0.31, 0.5, 1.0, 1.3, 1.7, 2.5, 2.9}) {
    LimitCycleReport<double> seen;
    const double at_s = speaks_at({.tilt_rad = sine(0.3, hz, 5.0)}, &seen);
    EXPECT_NEAR(at_s, 5.0 + (0.25 + 2.5 + 0.5 / 3.0) / hz + 0.5 * kStep_s, kStep_s);
    EXPECT_NEAR(seen.height_rad, 0.3, 0.001);
    EXPECT_NEAR(seen.frequency_hz, hz, 0.03 * hz);
    EXPECT_NEAR(speaks_at<float>({.tilt_rad = sine(0.3, hz, 5.0)}), at_s, 0.05);
  }
}

// Half-waves that are too long, too short, too low, too unlike in length or height: both sides of each bound.
TEST(LimitCycleDetector, CountsHalfWaves) {
  EXPECT_LT(speaks_at({.tilt_rad = sine(0.3, 0.29)}), 0.0);
  EXPECT_LT(speaks_at({.tilt_rad = sine(0.3, 3.1)}), 0.0);
  EXPECT_NEAR(speaks_at({.tilt_rad = sine(0.102, 1.3)}), (2.75 + 0.5 / 3.0) / 1.3 + 0.5 * kStep_s, kStep_s);
  const auto jump = [](double t_s) { return ref::AxisReference<double>{.position_m = t_s < 1.93 ? 0.0 : 0.5}; };
  EXPECT_NEAR(speaks_at({.tilt_rad = sine(0.12, 1.0), .reference = jump}), 2.25 + 2.5 + 0.5 / 3.0 + 0.5 * kStep_s,
              kStep_s)
      << "the half-wave of the jump is 0.09 rad high from there";
  EXPECT_LT(speaks_at({.tilt_rad = sine(0.098, 1.3)}), 0.0) << "a restless hover";
  for (const double ratio : {1.55, 1.65}) {
    const auto limps = [ratio](double t_s) {
      const double part_s = std::fmod(t_s, 0.25 * (1.0 + ratio));
      return 0.15 * (part_s < 0.25 ? std::cos(core::kPi * part_s / 0.25)
                                   : -std::cos(core::kPi * (part_s - 0.25) / (0.25 * ratio)));
    };
    EXPECT_EQ(speaks_at({.tilt_rad = limps}) > 0.0, ratio < 1.6);
  }
  for (const double rate_per_s : {0.17, 0.19}) {  // 0.7 over four half-waves: 0.178 per second
    const auto rings = [=](double t_s) { return 0.4 * std::exp(-rate_per_s * t_s) * std::sin(2.0 * core::kPi * t_s); };
    EXPECT_EQ(speaks_at({.tilt_rad = rings}) > 0.0, rate_per_s < 0.178);
  }
}

TEST(LimitCycleDetector, NoticesASwingThatGrows) {
  const auto grows = [](double t_s) { return 0.002 * std::exp(0.8 * t_s) * std::sin(2.0 * core::kPi * 1.3 * t_s); };
  const double at_s = speaks_at({.tilt_rad = grows});
  EXPECT_GT(at_s, 3.0);
  EXPECT_LT(at_s, 8.0);
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

// Both sides of the bound: the air explains a little less, or more, than a fifth of the tilt, as the motion
// shows it or as the observer estimates it. The estimate has its crests where the half-waves are divided.
TEST(LimitCycleDetector, NoticesASwingBeyondWhatTheAirExplains) {
  for (const double hz : {0.5, 1.0, 2.0}) {
    const double bound_m_s2 = 0.5 * kGravity_m_s2 / 5.0;
    for (const double share : {0.4, 1.5}) {
      const Motion pushed{.tilt_rad = sine(0.5, hz), .disturbance_acceleration_m_s2 = sine(share * bound_m_s2, hz)};
      EXPECT_EQ(speaks_at(pushed) > 0.0, share < 1.0) << hz;
    }
    for (const double share : {0.95, 1.05}) {
      const Motion estimated{.tilt_rad = sine(0.5, hz), .observed_m_s2 = sine(share * bound_m_s2, hz, 0.5 / 3.0 / hz)};
      EXPECT_EQ(speaks_at(estimated) > 0.0, share < 1.0) << hz;
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
  for (const double share : {0.95, 1.05}) {  // of the bounds of a jump
    const auto goals = [share](double t_s) {
      return ref::AxisReference<double>{.position_m = std::fmod(t_s, 2.0) < 1.0 ? 0.0 : share * 0.02};
    };
    EXPECT_EQ(speaks_at({.tilt_rad = sine(0.4, 1.0), .reference = goals}) < 0.0, share > 1.0);
    const auto legs = [share](double t_s) {
      const double part_s = std::fmod(t_s, 2.0), v = share * 0.1;
      return part_s < 1.0 ? ref::AxisReference<double>{std::floor(t_s / 2.0) * v, 0.0, 0.0}
                          : ref::AxisReference<double>{(std::floor(t_s / 2.0) + part_s - 1.0) * v, v, 0.0};
    };
    EXPECT_EQ(speaks_at({.tilt_rad = sine(0.4, 1.0), .reference = legs}) < 0.0, share > 1.0);
  }
}

TEST(LimitCycleDetector, LooksAwayAndBeginsAnew) {
  LimitCycleDetector<double> watch;
  const auto watch_for = [&](double time_s, bool flies, double stall_s) {  // every second one tick takes so long
    double t_s = 0.0;
    for (int tick = 1; t_s < time_s; ++tick) {
      const double step_s = tick % 100 == 0 ? stall_s : kStep_s;
      t_s += step_s;
      watch.update(swinging(0.4, 1.3, t_s), {}, flies, step_s);
    }
    return watch.report().detected;
  };
  EXPECT_TRUE(watch_for(4.0, true, kStep_s));
  watch.pause(2.0);
  EXPECT_FALSE(watch.report().detected);
  EXPECT_FALSE(watch_for(3.5, true, kStep_s));
  EXPECT_TRUE(watch_for(4.0, true, kStep_s)) << "two seconds later it counts again";
  EXPECT_FALSE(watch_for(0.1, false, kStep_s)) << "the law does not fly";
  EXPECT_TRUE(watch_for(4.0, true, 0.0245));
  EXPECT_FALSE(watch_for(4.0, true, 0.0255)) << "ticks that stall";
}

// An aircraft that comes to rest oscillates no more two of the longest half-waves after its last turning point.
TEST(LimitCycleDetector, ForgetsASwingThatHasStopped) {
  LimitCycleDetector<double> watch;
  double stopped_s = 0.0;
  for (double t_s = 0.0; t_s < 8.0; t_s += kStep_s) {
    watch.update(swinging(t_s < 3.0 ? 0.3 : 0.0, 1.3, t_s), {}, true, kStep_s);
    stopped_s = watch.report().detected ? t_s : stopped_s;
  }
  EXPECT_NEAR(stopped_s, 3.75 / 1.3 + 2.0 * 0.5 / 0.3, 1.5 * kStep_s);
}

// Catches a watch that does not remember that one swing has been noticed, or never forgets it: after a pause fewer
// half-waves are enough for as long as the law flies.
TEST(LimitCycleDetector, AfterAPauseFewerHalfWavesAreEnoughUntilTheLawStopsFlying) {
  constexpr double kHalfWave_s = 0.5 / 1.3;
  LimitCycleDetector<double> watch;
  double t_s = 0.0;
  const auto tick = [&](bool flies) {
    watch.update(swinging(0.4, 1.3, t_s), {}, flies, kStep_s);
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
  EXPECT_NEAR(again_s, 3.0 * kHalfWave_s, 1.5 * kStep_s);
  watch.pause(0.0);
  tick(false);
  const double anew_s = time_to_notice_s();
  EXPECT_GT(anew_s, LimitCycleDetector<double>::kHalfWaves * kHalfWave_s);
}

TEST(LimitCycleDetector, ReportsTheHigherOfTwoSwingsWithItsOwnFrequency) {
  for (const bool higher_in_x : {true, false}) {
    LimitCycleDetector<double> watch;
    for (double t_s = 0.0; t_s < 6.0; t_s += kStep_s) {
      est::Estimate<double> estimate = swinging(higher_in_x ? 0.4 : 0.3, 1.0, t_s);
      estimate.y = swinging(higher_in_x ? 0.3 : 0.4, 1.6, t_s).x;
      estimate.y.position_m *= -1.0;
      watch.update(estimate, {}, true, kStep_s);
    }
    ASSERT_TRUE(watch.report().detected);
    EXPECT_NEAR(watch.report().height_rad, 0.4, 0.03);
    EXPECT_NEAR(watch.report().frequency_hz, higher_in_x ? 1.0 : 1.6, 0.1);
  }
}

// The fallback flies from the first limit cycle on, not for a movement of the sticks' plan; the failsafe hears of it if
// the aircraft still oscillates when two seconds have passed.
TEST(LimitCycleResponse, FliesTheFallbackAndTellsWhetherThatHelps) {
  for (const bool enabled : {true, false}) {
    const mpc::GainTables<double> tables{.x = mpc::generated::kX<double>, .y = mpc::generated::kY<double>};
    FlightLaw<double> law(mpc::generated::kVehicle, tables);
    LimitCycleResponse<double> response({.reaction_s = 0.35}, enabled);
    double t_s = 0.0;
    const auto fly = [&](double time_s, double height_rad, bool flies = true, bool excited = false) {
      for (const double end_s = t_s + time_s; t_s < end_s; t_s += kStep_s) {
        response.update(swinging(height_rad, 1.3, t_s), {}, flies, excited, kStep_s, law);
      }
      return response.status();
    };
    EXPECT_FALSE(response.status().detected || response.persists());
    EXPECT_FALSE(fly(4.0, 0.4, true, true).detected);
    EXPECT_FALSE(fly(4.0, 0.4, false).detected);
    const LimitCycleStatus noticed = fly(3.5, 0.4);
    EXPECT_EQ(noticed.detected, enabled);
    EXPECT_EQ(law.fallback(), enabled);
    EXPECT_FALSE(noticed.persists);
    EXPECT_NEAR(noticed.height_rad, 0.4, 0.01);
    EXPECT_NEAR(noticed.frequency_hz, 1.3, 0.04);
    EXPECT_FALSE(fly(2.6, 0.4).persists);
    EXPECT_EQ(fly(0.2, 0.4).persists, enabled);
    EXPECT_EQ(response.persists(), enabled);
    const LimitCycleStatus calm = fly(4.0, 0.0);
    EXPECT_FALSE(calm.persists);
    EXPECT_NEAR(calm.height_rad, 0.4, 0.01) << "the last one of this flight";
    EXPECT_EQ(fly(0.01, 0.0, false).height_rad, 0.0);
  }
}

}  // namespace
}  // namespace m100::ctl
