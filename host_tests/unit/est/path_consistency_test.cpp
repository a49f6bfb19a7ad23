// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/consistency/path_consistency.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "firmware/est/consistency/motion_noise.h"
#include "firmware/est/lever_arm_fit.h"

namespace m100::est {
namespace {

constexpr double kTick_s = 0.01;
using Vector2 = core::Vector<double, 2>;

/// An aircraft that is accelerated, and the pose that a test makes of its motion.
class PathConsistencyTest : public ::testing::Test {
 protected:
  struct Seen {
    Vector2 position_m;
    Vector2 speed_m_s;
    bool is_new = true;
  };
  using Tell = std::function<Seen(const Vector2& position_m, const Vector2& speed_m_s, double t_s)>;

  static Seen truly(const Vector2& position_m, const Vector2& speed_m_s, double) { return {position_m, speed_m_s}; }

  /// Continues the flight.
  /// @param disturbance_acceleration acceleration in m/s^2 at a time.
  /// @returns after how many seconds the check objects, or the time flown.
  double fly(double seconds, const std::function<Vector2(double t_s)>& disturbance_acceleration, const Tell& tell) {
    for (double t_s = 0.0; t_s < seconds - 1e-9; t_s += kTick_s) {
      const Vector2 acceleration = disturbance_acceleration(now_s_);
      place_m_ += speed_m_s_ * kTick_s + 0.5 * kTick_s * kTick_s * acceleration;
      speed_m_s_ += acceleration * kTick_s;
      const Seen seen = tell(place_m_, speed_m_s_, t_s);
      check_.update({.force_m_s2 = acceleration + offset_m_s2_ + 0.1 * noise(),
                     .position_m = seen.position_m + 0.001 * noise(),
                     .speed_m_s = seen.speed_m_s},
                    seen.is_new, kTick_s);
      now_s_ += kTick_s;
      if (check_.evidence() >= 1.0) {
        return t_s;
      }
    }
    return seconds;
  }
  Vector2 noise() { return {normal_(random_), normal_(random_)}; }

  /// A hover within centimetres, with the frequencies of the control loop.
  static Vector2 hovers(double t_s) {
    return {0.05 * std::sin(1.3 * t_s) + 0.03 * std::sin(2.9 * t_s), 0.05 * std::sin(1.7 * t_s + 1.0)};
  }
  /// Alternating motion over metres at 2 m/s.
  static Vector2 travels(double t_s) { return {3.0 * std::sin(1.5 * t_s), 0.0}; }

  PathConsistency<double> check_;
  Vector2 offset_m_s2_{0.04, -0.03};  ///< what the learned one lacks
  Vector2 place_m_ = Vector2::Zero();
  Vector2 speed_m_s_ = Vector2::Zero();
  double now_s_ = 0.0;
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
};

TEST_F(PathConsistencyTest, BeforeAnyMotionThereIsNoEvidenceAndNoDistance) {
  EXPECT_EQ(check_.evidence(), 0.0);
  EXPECT_EQ(check_.residual_m(), 0.0);
  EXPECT_EQ(check_.allowed_m(), 0.0);
}

TEST_F(PathConsistencyTest, IsSilentForTenMinutesOfHoverAndOfTravel) {
  RecordProperty("promise", "R17");
  EXPECT_EQ(fly(300.0, hovers, truly), 300.0);
  EXPECT_EQ(fly(300.0, travels, truly), 300.0);
}

// An attitude that drifts by a tenth of a degree within two seconds shows a force that does not exist.
TEST_F(PathConsistencyTest, IsSilentUnderAWanderingAttitude) {
  RecordProperty("promise", "R17");
  double wander_m_s2 = 0.0;
  EXPECT_EQ(fly(120.0, hovers,
                [&](const Vector2& position_m, const Vector2& speed_m_s, double) {
                  wander_m_s2 += -0.5 * kTick_s * wander_m_s2 + 0.017 * std::sqrt(kTick_s) * noise().x();
                  offset_m_s2_.x() = 0.04 + wander_m_s2;
                  return Seen{position_m, speed_m_s};
                }),
            120.0);
}

TEST_F(PathConsistencyTest, NamesAStandingBody) {
  RecordProperty("promise", "R14");
  ASSERT_EQ(fly(20.0, hovers, truly), 20.0);
  const Vector2 stands = place_m_;
  const auto pushed = [](double t_s) -> Vector2 {
    return hovers(t_s) + Vector2(0.1, 0.0);
  };  // no control holds it against the air
  EXPECT_LT(fly(30.0, pushed,
                [&](const Vector2&, const Vector2&, double) {
                  return Seen{stands, Vector2::Zero()};
                }),
            4.0);
}

// In calm air a body that stands differs from a hover by less than the limit at any moment; only the sum over some
// seconds tells. Catches a check without that sum, or one that does not sum after the paths have settled.
TEST_F(PathConsistencyTest, NamesAStandingBodyInACalmHoverByTheSumOfSeconds) {
  RecordProperty("promise", "R14");
  const auto calmly = [](double t_s) -> Vector2 { return 0.7 * hovers(t_s); };
  ASSERT_EQ(fly(20.0, calmly, truly), 20.0);
  const Vector2 stands = place_m_;
  const double seen_s = fly(60.0, calmly, [&](const Vector2&, const Vector2&, double) {
    return Seen{stands, Vector2::Zero()};
  });
  EXPECT_LT(seen_s, 8.0);
  EXPECT_GT(seen_s, 0.5) << "no single moment tells it";
}

TEST_F(PathConsistencyTest, NamesADriftAsItBegins) {
  RecordProperty("promise", "R14");
  ASSERT_EQ(fly(20.0, hovers, truly), 20.0);
  const double seen_s = fly(10.0, hovers, [](const Vector2& position_m, const Vector2& speed_m_s, double t_s) {
    return Seen{position_m + Vector2(0.3 * t_s, 0.0), speed_m_s + Vector2(0.3, 0.0)};
  });
  EXPECT_LT(seen_s, 0.5);
}

TEST_F(PathConsistencyTest, NamesAFrameThatIsTurnedOnceSomethingMoves) {
  RecordProperty("promise", "R14");
  const Tell turned = [](const Vector2& p, const Vector2& v, double) {
    const double c = std::cos(0.35), s = std::sin(0.35);
    return Seen{{c * p.x() - s * p.y(), s * p.x() + c * p.y()}, {c * v.x() - s * v.y(), s * v.x() + c * v.y()}};
  };
  EXPECT_LT(fly(10.0, travels, turned), 5.0);
}

// A pose whose time stamp is wrong by 80 ms shows the same path with a small shift: this is found elsewhere and is no
// lie.
TEST_F(PathConsistencyTest, AWrongTimeIsNoFault) {
  RecordProperty("promise", "R17");
  const Tell late = [](const Vector2& p, const Vector2& v, double) { return Seen{p - 0.08 * v, v}; };
  EXPECT_EQ(fly(60.0, hovers, late), 60.0);
  EXPECT_EQ(fly(60.0, travels, late), 60.0);
}

// Half a second without a pose every four seconds, after which the observer is wrong by 10 cm and 0.2 m/s.
TEST_F(PathConsistencyTest, IsSilentOverGaps) {
  RecordProperty("promise", "R17");
  const Tell gaps = [](const Vector2& p, const Vector2& v, double t_s) {
    const double phase_s = std::fmod(t_s, 4.0);
    const bool gap = phase_s < 0.5;
    const double wrong_m_s = gap ? 0.2 : 0.2 * std::exp(-(phase_s - 0.5) / 0.1);
    const double wrong_m = gap ? 0.2 * phase_s : 0.1 * std::exp(-(phase_s - 0.5) / 0.1);
    return Seen{p + Vector2(wrong_m, 0.0), v + Vector2(wrong_m_s, 0.0), phase_s < 0.14 || !gap};
  };
  EXPECT_EQ(fly(100.0, travels, gaps), 100.0);
}

// Would catch a check that applies a gap before the restart to the time after it: the path of that time no longer
// counts.
TEST_F(PathConsistencyTest, ARestartForgetsTheGapBefore) {
  PathConsistency<double> fresh;
  PathConsistency<double> restarted;
  for (int tick = 0; tick < 600; ++tick) {  // the time scales take turns, so a multiple of three
    restarted.update({.force_m_s2 = travels(0.01 * tick), .position_m = {9.0, 9.0}, .speed_m_s = {1.0, 0.0}},
                     tick < 570, kTick_s);
  }
  restarted.restart();
  EXPECT_EQ(restarted.evidence(), 0.0);
  double most = 0.0;
  for (int tick = 0; tick < 300; ++tick) {
    const PathConsistency<double>::PathInput stands{.force_m_s2 = travels(0.01 * tick)};
    fresh.update(stands, true, kTick_s);
    restarted.update(stands, true, kTick_s);
    ASSERT_EQ(restarted.evidence(), fresh.evidence()) << tick;
    most = std::max(most, fresh.evidence());
  }
  EXPECT_GE(most, 1.0) << "else the two agree about nothing";
}

// The pose shows a body at rest while the height of the aircraft oscillates at 7 cm/s, about as in the measured logs.
// Catches a sum that waits for two axes, and a check that objects to a true height.
TEST(PathConsistencyVertical, NamesAHeightThatStandsAndNoHonestOne) {
  RecordProperty("promise", "R14");
  using Vector1 = core::Vector<double, 1>;
  std::mt19937 random{1};
  std::normal_distribution<double> normal;
  PathConsistency<double, 1> check;
  double height_m = 0.0, seen_s = 0.0;
  for (double t_s = 0.0; t_s < 70.0 && check.evidence() < 1.0; t_s += kTick_s) {
    const double climb_m_s = 0.07 * std::sin(5.0 * t_s);
    height_m += climb_m_s * kTick_s;
    const bool stands = t_s > 60.0;
    check.update({.force_m_s2 = Vector1(0.35 * std::cos(5.0 * t_s) + 0.1 * normal(random)),
                  .position_m = Vector1((stands ? 0.0 : height_m) + 0.001 * normal(random)),
                  .speed_m_s = Vector1(stands ? 0.0 : climb_m_s)},
                 true, kTick_s);
    seen_s = t_s;
  }
  EXPECT_GE(check.evidence(), 1.0);
  EXPECT_GT(seen_s, 60.0) << "an honest height was called a sensor fault";
  EXPECT_LT(seen_s, 63.0);
}

// An aircraft that leans by 25 degrees against a gust and returns turns part of the offsets of x and y upwards: offsets
// of 0.2 m/s^2 give a force of 0.085 that moves nothing. Catches a check that takes the height for a sensor fault.
TEST(PathConsistencyVertical, IsSilentOverOffsetsThatALeanTurnsUpwards) {
  RecordProperty("promise", "R17");
  using Vector1 = core::Vector<double, 1>;
  for (const bool reported : {true, false}) {
    PathConsistency<double, 1> check;
    double spoke_s = 0.0;
    for (double t_s = 0.0; t_s < 40.0 && check.evidence() < 1.0; t_s += kTick_s) {
      const bool leans = std::fmod(t_s, 2.0) < 1.0;
      check.update({.force_m_s2 = Vector1(leans ? 0.085 : 0.0),
                    .position_m = Vector1(0.0),
                    .speed_m_s = Vector1(0.0),
                    .tilt_acceleration_m2_s4 = reported ? 5.3 : 0.0},  // of 2.3: half of 4.6, from the mean
                   true, kTick_s);
      spoke_s = t_s;
    }
    EXPECT_EQ(spoke_s > 39.0, reported) << spoke_s;
  }
}

// Five times the rotor vibration and poses that scatter by a centimetre: no objection if both are known; if not, they
// look like a sensor fault.
TEST_F(PathConsistencyTest, IsSilentOverWorseSensorsThatWereMeasured) {
  RecordProperty("promise", "R17");
  for (const bool reported : {true, false}) {
    check_ = {};
    double spoke_s = 0.0;
    for (double t_s = 0.0; t_s < 60.0 && check_.evidence() < 1.0; t_s += kTick_s) {
      place_m_ += speed_m_s_ * kTick_s + 0.5 * kTick_s * kTick_s * hovers(t_s);
      speed_m_s_ += hovers(t_s) * kTick_s;
      check_.update({.force_m_s2 = hovers(t_s) + 0.5 * noise(),
                     .position_m = place_m_ + 0.003 * noise(),
                     .speed_m_s = speed_m_s_,
                     .position_noise_m2 = reported ? 4e-6 : 0.0,
                     .force_noise_m2_s3 = reported ? 2.5e-3 : 0.0},
                    true, kTick_s);
      spoke_s = t_s;
    }
    EXPECT_EQ(spoke_s > 59.0, reported) << spoke_s;
  }
}

// A hover, then a turn by a radian in a second with the origin of the pose beside the centre of gravity; or a pose that
// drifts without a turn, or in one. Catches a lever of the wrong sign or axes, and one that any difference would name.
TEST_F(PathConsistencyTest, ALeverArmIsFoundInATurnAndIsNotTheNameOfADrift) {
  for (const auto& [lever_b_m, drift_m_s, turns] : {std::tuple{Vector2(0.1, 0.0), 0.0, true},
                                                    {Vector2(-0.2, 0.15), 0.0, true},
                                                    {Vector2(0.0, -0.3), 0.0, true},
                                                    {Vector2(0.3, 0.0), 0.0, false},
                                                    {Vector2(0.0, 0.0), 0.5, false},
                                                    {Vector2(0.0, 0.0), 0.5, true}}) {
    check_ = {};
    place_m_ = speed_m_s_ = Vector2::Zero();
    LeverArmFit<double> fit;
    for (double t_s = 0.0; t_s < 11.0; t_s += kTick_s) {
      place_m_ += speed_m_s_ * kTick_s + 0.5 * kTick_s * kTick_s * hovers(t_s);
      speed_m_s_ += hovers(t_s) * kTick_s;
      const double turned_s = t_s > 10.0 ? t_s - 10.0 : 0.0;
      const core::SinCos<double> yaw = core::sin_cos_of(0.7 + (turns ? turned_s : 0.0));
      check_.update({.force_m_s2 = hovers(t_s) + 0.1 * noise(),
                     .position_m = place_m_ + core::rotate(lever_b_m, yaw) + Vector2(drift_m_s * turned_s, 0.0),
                     .speed_m_s = speed_m_s_},
                    true, kTick_s);
      fit.update(yaw, check_.apart_m(), PathConsistency<double>::kApart_per_s, kTick_s,
                 check_.apart_is_new() ? 3.0 * kTick_s : 0.0);
      EXPECT_TRUE(t_s > 10.0 || fit.lever_b_m().isZero()) << t_s;
    }
    const bool is_lever = turns && drift_m_s == 0.0;
    EXPECT_LE((fit.lever_b_m() - (is_lever ? lever_b_m : Vector2(0.0, 0.0))).norm(), 0.3 * lever_b_m.norm())
        << fit.lever_b_m().x() << " " << fit.lever_b_m().y();
  }
}

// Force and position alternate about a steady flight, on each axis by its own size: the mean squares of the header, and
// a memory of three seconds.
TEST(MotionNoise, IsTheMeanSquareOfSuccessiveDifferences) {
  SpecificForce<double> force;
  MotionNoise<double> noise;
  Estimate<double> estimate;
  estimate.x.velocity_m_s = 0.3;
  estimate.y.velocity_m_s = -0.2;
  estimate.climb_m_s = 0.1;
  estimate.height_gain = 0.8;
  estimate.climb_gain_per_s = 8.0;
  const auto fly = [&](int ticks, double size) {
    for (int tick = 1; tick <= ticks; ++tick) {
      const double sign = tick % 2 == 0 ? size : -size;
      ImuSample<double> imu{.force_is_new = true};
      imu.force_b = {0.1 * sign, -0.05 * sign, 9.8066 + 0.04 * sign};
      estimate.x.position_m = 0.003 * tick + 0.001 * sign;
      estimate.y.position_m = -0.002 * tick + 0.002 * sign;
      estimate.height_m = 0.001 * tick + 0.003 * sign;
      force.update(imu);
      force.learn({0.0, 0.0}, 0.0, false, kTick_s);
      noise.update(imu, force, estimate, true, kTick_s);
    }
  };
  EXPECT_EQ(noise.magnitude(), 0.0);
  fly(8000, 1.0);
  const double corner = std::tan(core::kPi * 15.0 * kTick_s);  // half the rate passes whole, of white noise this share
  const double white_gain = (1.0 + 0.5 * corner) / ((1.0 + corner) * (1.0 + corner));
  const double force_m2_s3 = 0.5 * (0.1 * 0.1 + 0.05 * 0.05) * kTick_s / white_gain;
  EXPECT_NEAR(noise.vibration().density_m2_s3().horizontal, force_m2_s3, 1e-9);
  EXPECT_NEAR(noise.vibration().density_m2_s3().vertical, 0.04 * 0.04 * kTick_s / white_gain, 1e-9);
  EXPECT_NEAR(noise.position_m2().horizontal, 0.25 * (0.004 * 0.004 + 0.008 * 0.008), 1e-10);
  EXPECT_NEAR(noise.position_m2().vertical, 0.5 * 0.012 * 0.012 * 0.25 / estimate.height_gain, 1e-10);
  EXPECT_NEAR(noise.climb_m2_s2(), 2.0 * noise.position_m2().vertical * 10.0 * 10.0, 1e-10);
  fly(300, 0.0);
  EXPECT_NEAR(noise.vibration().density_m2_s3().horizontal, force_m2_s3 * std::exp(-1.0), 0.01 * force_m2_s3);
}

}  // namespace
}  // namespace m100::est
