// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/axis_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "firmware/est/filter/height_filter.h"
#include "firmware/model/default_vehicle.h"

namespace m100::est {
namespace {

/// Velocity after one tick from rest at a tilt that equals the command; it is proportional to the acceleration.
double gained(double tilt_rad) {
  using Filter = AxisFilter<double>;
  AxisModel model;
  model.attitude = model::paper_vehicle().pitch;
  Filter filter(model);
  filter.start(tilt_rad);
  filter.predict({.now = tilt_rad, .before = tilt_rad, .after = tilt_rad});
  EXPECT_NEAR(filter.state(Filter::kTilt), tilt_rad, 1e-12) << "nothing turns";
  return filter.state(Filter::kV);
}

// Catches a wrong coefficient of the approximated tangent: an error of 1 % at the largest tilt is 0.07 m/s^2 and would
// be estimated as wind.
TEST(AxisFilter, AcceleratesByTheTangentOfTheTilt) {
  const double unit = gained(0.01) / std::tan(0.01);
  EXPECT_GT(unit, 0.0);
  for (const double tilt_rad : {-0.65, -0.3, 0.1, 0.2, 0.35, 0.5, 0.65}) {
    EXPECT_NEAR(gained(tilt_rad) / unit, std::tan(tilt_rad), 2e-6) << tilt_rad;
  }
}

// Catches a state outside of the range that its filter's header promises, in which fixed point and the tangent hold.
TEST(Ranges, EachStateEndsAtTheEndOfItsOwn) {
  using Filter = AxisFilter<double>;
  AxisModel model;
  model.attitude = model::paper_vehicle().pitch;
  for (const double sign : {-1.0, 1.0}) {
    Filter axis(model);
    axis.start(sign * 1e3);
    axis.reset_position(sign * 1e3, sign * 1e3, 0.0, {});
    EXPECT_EQ(axis.state(Filter::kP), sign * 100.0);
    EXPECT_EQ(axis.state(Filter::kV), sign * 25.0);
    EXPECT_EQ(axis.state(Filter::kTilt), sign * 0.7);
    axis.predict({.now = sign * 1e3, .before = -sign * 1e3, .after = sign * 1e3});
    EXPECT_EQ(axis.state(Filter::kRate), sign * 10.0);
    axis.fuse_specific_force(0.0, Filter::DisturbanceUse::kStored);
    axis.fuse_specific_force(sign * 1e3, Filter::DisturbanceUse::kTracked);
    EXPECT_EQ(axis.state(Filter::kD), sign * 8.0);
    HeightFilter<double> height(model.attitude, 0.002);
    height.reset_position(sign * 1e3, sign * 1e3, 0.0, {});
    EXPECT_EQ(height.state(HeightFilter<double>::kZ), sign * 100.0);
    EXPECT_EQ(height.state(HeightFilter<double>::kClimb), sign * 10.0);
  }
}

/// The variance of the position after a start from poses of 1 km and `ticks` poses of 2 mm.
template <typename S>
double settled_variance_m2(int ticks) {
  AxisModel model;
  model.attitude = model::paper_vehicle().pitch;
  AxisFilter<S> filter(model);
  filter.reset_position(S(0), S(0), S(0), {.position_m2 = 1e6, .velocity_m2_s2 = 1e8});
  for (int tick = 0; tick < ticks; ++tick) {
    filter.predict({});
    filter.fuse_attitude(S(0), S(0), S(0));
    filter.fuse_pose(filter.test_pose(S(0), S(0.02), S(0), S(0)));
    EXPECT_TRUE(filter.is_sane()) << tick;
  }
  return static_cast<double>(filter.covariance(AxisFilter<S>::kP, AxisFilter<S>::kP));
}

// Catches a covariance that is lost in the rounding of the one before: that of 1e4 m^2 is 6e-4 m^2 in float, and a pose
// of 2 mm has 4e-6 m^2. The plain P - K H P left negative variances.
TEST(AxisFilter, IsAsSureInFloatAsInDoubleWhenPosesOfAKilometreBecomeGood) {
  for (const int ticks : {1, 2, 5, 20, 100}) {
    const double in_double = settled_variance_m2<double>(ticks);
    EXPECT_NEAR(settled_variance_m2<float>(ticks) / in_double, 1.0, 0.1) << ticks;
  }
}

// Catches a covariance beyond its range: with time constants up to 70 ms the observer once restarted in every tick.
TEST(HeightFilter, StartsOnFastClimbAxesAndWithOldPoses) {
  for (const double time_constant_s : {0.01, 0.05, 1.5}) {
    for (const double age_s : {0.0, kMaxPoseAge_s}) {
      HeightFilter<core::Fixed> filter({.time_constant_s = time_constant_s}, 0.0018);
      const core::Fixed zero(0);
      filter.reset_position(zero, zero, zero, {});
      for (int tick = 0; tick < 100; ++tick) {
        filter.fuse_pose(filter.test_pose(zero, core::Fixed(age_s), zero, zero));
        filter.predict({});
        ASSERT_TRUE(filter.is_sane()) << time_constant_s << " s, age " << age_s << ", tick " << tick;
      }
    }
  }
}

// The numbers are exact in double: 36 s is (0.75 m)^2, so 0.75 m are six sigmas. Each bound is still inside; the next
// number is not.
TEST(InsideGate, EachBoundIsInsideAndTheNextNumberIsNot) {
  constexpr double kSixSigmas_m = 0.75, kScaled = kSixSigmas_m * kSixSigmas_m / 36.0, kLarge = 100.0;
  constexpr double kSixOfNoise_m = 1.5, kNoise = kSixOfNoise_m * kSixOfNoise_m / 36.0;
  const auto next = [](double value) { return std::nextafter(value, 2.0 * value); };
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_TRUE(inside_gate(sign * kSixSigmas_m, kScaled, 0.0, 0.0));
    EXPECT_FALSE(inside_gate(sign * next(kSixSigmas_m), kScaled, 0.0, 0.0));
    EXPECT_TRUE(inside_gate(sign * 0.875, kScaled, 0.0, 0.875)) << "what may have happened unseen";
    EXPECT_FALSE(inside_gate(sign * next(0.875), kScaled, 0.0, 0.875));
    EXPECT_TRUE(inside_gate(sign * kLargestInnovation_m, kLarge, 0.0, 0.0));
    EXPECT_FALSE(inside_gate(sign * next(kLargestInnovation_m), kLarge, 0.0, 2.0)) << "whatever else is true";
    EXPECT_TRUE(inside_gate(sign * kSixOfNoise_m, kLarge, kNoise, 0.0)) << "the noise that the sender states";
    EXPECT_FALSE(inside_gate(sign * next(kSixOfNoise_m), kLarge, kNoise, 2.0));
  }
}

}  // namespace
}  // namespace m100::est
