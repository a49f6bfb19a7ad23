// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/est/filter/axis_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "firmware/est/filter/filter_math.h"
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
    axis.reset_position(sign * 1e3, sign * 1e3, {}, {});
    EXPECT_EQ(axis.state(Filter::kP), sign * 100.0);
    EXPECT_EQ(axis.state(Filter::kV), sign * 25.0 * kTimeUnit_s);
    EXPECT_EQ(axis.state(Filter::kTilt), sign * 0.7);
    axis.predict({.now = sign * 1e3, .before = -sign * 1e3, .after = sign * 1e3});
    EXPECT_EQ(axis.state(Filter::kRate), sign * 10.0 * kTimeUnit_s);
    axis.fuse_specific_force(0.0, Filter::DisturbanceUse::kStored);
    axis.fuse_specific_force(sign * 1e3, Filter::DisturbanceUse::kTracked);
    EXPECT_EQ(axis.state(Filter::kD), sign * 8.0 * kTimeUnit_s * kTimeUnit_s);
    HeightFilter<double> height(model.attitude, 0.002);
    height.reset_position(sign * 1e3, sign * 1e3, {}, {});
    EXPECT_EQ(height.state(HeightFilter<double>::kZ), sign * 100.0);
    EXPECT_EQ(height.state(HeightFilter<double>::kClimb), sign * 10.0 * kTimeUnit_s);
  }
}

// Catches a covariance beyond its range: with time constants up to 70 ms the observer once restarted in every tick.
TEST(HeightFilter, StartsOnFastClimbAxesAndWithOldPoses) {
  for (const double time_constant_s : {0.01, 0.05, 1.5}) {
    for (const double age_s : {0.0, kMaxPoseAge_s}) {
      HeightFilter<core::Fixed> filter({.time_constant_s = time_constant_s}, 0.0018);
      filter.reset_position({}, {}, {}, {});
      for (int tick = 0; tick < 100; ++tick) {
        filter.fuse_pose(filter.test_pose({}, MeasurementAge<core::Fixed>::of(age_s), {}, 0.F));
        filter.predict({});
      }
      const CovarianceHealth health = filter.health();
      EXPECT_EQ(health.ceilings + health.floors + health.saturations, 0U) << time_constant_s << " s, age " << age_s;
    }
  }
}

// The numbers are exact in double: 36 s is (0.75 m)^2, so 0.75 m are six sigmas. Each bound is still inside; the next
// number is not.
TEST(InsideGate, EachBoundIsInsideAndTheNextNumberIsNot) {
  constexpr double kSixSigmas_m = 0.75, kScaled = kSixSigmas_m * kSixSigmas_m / 36.0, kLarge = 100.0;
  constexpr double kSixOfNoise_m = 1.5, kNoise = kSixOfNoise_m * kSixOfNoise_m / 36.0;
  core::Arithmetic<double> a;
  const auto next = [](double value) { return std::nextafter(value, 2.0 * value); };
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_TRUE(inside_gate(a, sign * kSixSigmas_m, kScaled, 0.0, 0, 0.0));
    EXPECT_FALSE(inside_gate(a, sign * next(kSixSigmas_m), kScaled, 0.0, 0, 0.0));
    EXPECT_TRUE(inside_gate(a, sign * 0.875, kScaled, 0.0, 0, 0.875)) << "what may have happened unseen";
    EXPECT_FALSE(inside_gate(a, sign * next(0.875), kScaled, 0.0, 0, 0.875));
    EXPECT_TRUE(inside_gate(a, sign * kLargestInnovation_m, kLarge, 0.0, 0, 0.0));
    EXPECT_FALSE(inside_gate(a, sign * next(kLargestInnovation_m), kLarge, 0.0, 0, 2.0)) << "whatever else is true";
    EXPECT_TRUE(inside_gate(a, sign * kSixOfNoise_m, kLarge, kNoise, 0, 0.0)) << "the noise that the sender states";
    EXPECT_FALSE(inside_gate(a, sign * next(kSixOfNoise_m), kLarge, kNoise, 0, 2.0));
  }
}

}  // namespace
}  // namespace m100::est
