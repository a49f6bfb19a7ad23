// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/core/tilt.h"

#include <gtest/gtest.h>

namespace m100::core {
namespace {

Vector<double, 3> body_z_in_world(const Euler<double>& e) {
  const Quaternion<double> q = quaternion_of(e);
  return {2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y)};
}

/// The attitude after the body has turned for this time.
Euler<double> turned(const Euler<double>& e, const Vector<double, 3>& rate, double t) {
  const Quaternion<double> q = quaternion_of(e);
  const Quaternion<double> d{1.0, 0.5 * t * rate.x(), 0.5 * t * rate.y(), 0.5 * t * rate.z()};
  return euler_of(
      Quaternion<double>{q.w * d.w - q.x * d.x - q.y * d.y - q.z * d.z, q.w * d.x + q.x * d.w + q.y * d.z - q.z * d.y,
                         q.w * d.y - q.x * d.z + q.y * d.w + q.z * d.x, q.w * d.z + q.x * d.y - q.y * d.x + q.z * d.w});
}

class TiltOverAttitudes : public ::testing::TestWithParam<Euler<double>> {};

// Catches a yaw of the wrong sign, and a wrong sign of roll.
TEST_P(TiltOverAttitudes, IsWhereTheBodyAxisPoints) {
  const Euler<double>& e = GetParam();
  const Vector<double, 3> z = body_z_in_world(e);
  const Tilt<double> tilt = tilt_of(e);
  EXPECT_NEAR(tan(tilt.x_rad), z.x() / z.z(), 1e-12);
  EXPECT_NEAR(tan(tilt.y_rad), -z.y() / z.z(), 1e-12);
}

TEST_P(TiltOverAttitudes, ComesBackAsAttitude) {
  const Euler<double>& e = GetParam();
  const Euler<double> back = attitude_of(tilt_of(e), e.yaw_rad);
  EXPECT_NEAR(back.roll_rad, e.roll_rad, 1e-12);
  EXPECT_NEAR(back.pitch_rad, e.pitch_rad, 1e-12);
}

// Catches body rates that are taken for Euler rates: the rate must equal the difference quotient over a small turn of
// the body.
TEST_P(TiltOverAttitudes, RateIsTheDerivativeAlongATurnOfTheBody) {
  const Euler<double>& e = GetParam();
  const Vector<double, 3> rate{0.4, -0.7, 1.1};
  const double h = 1e-5;
  const Tilt<double> after = tilt_of(turned(e, rate, h));
  const Tilt<double> before = tilt_of(turned(e, rate, -h));
  const Tilt<double> found = tilt_rate_of(e, rate);
  EXPECT_NEAR(found.x_rad, (after.x_rad - before.x_rad) / (2 * h), 1e-8);
  EXPECT_NEAR(found.y_rad, (after.y_rad - before.y_rad) / (2 * h), 1e-8);
}

// Catches a gyro's z rate that is taken for the heading rate, and a wrong sign of one of its two terms.
TEST_P(TiltOverAttitudes, HeadingRateIsTheDerivativeOfTheHeading) {
  const Euler<double>& e = GetParam();
  const Vector<double, 3> rate{0.4, -0.7, 1.1};
  const double h = 1e-5;
  EXPECT_NEAR(yaw_rate_of(attitude_sin_cos(e), rate),
              (turned(e, rate, h).yaw_rad - turned(e, rate, -h).yaw_rad) / (2 * h), 1e-8);
}

TEST_P(TiltOverAttitudes, AStandingSlopeIsTheSlopeHoweverTheHeadingTurns) {
  const Euler<double>& e = GetParam();
  CachedTilt<double> standing;
  for (const double yaw_rad : {e.yaw_rad, e.yaw_rad + 0.5, -2.0}) {
    for (const double roll_rad : {e.roll_rad, e.roll_rad, e.roll_rad + 0.1}) {
      for (const double pitch_rad : {e.pitch_rad, e.pitch_rad - 0.1}) {
        const Euler<double> now{roll_rad, pitch_rad, yaw_rad};
        const Slope<double> found = standing.at(roll_rad, pitch_rad, sin_cos_of(yaw_rad));
        EXPECT_EQ(found.x, slope_of(attitude_sin_cos(now)).x);
        EXPECT_EQ(found.y, slope_of(attitude_sin_cos(now)).y);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Attitudes, TiltOverAttitudes,
                         ::testing::Values(Euler<double>{0, 0, 0}, Euler<double>{0.3, 0, 0}, Euler<double>{0, 0.3, 0},
                                           Euler<double>{0.2, -0.3, 1.0}, Euler<double>{-0.4, 0.1, -2.5},
                                           Euler<double>{0.1, 0.4, 3.1}));

}  // namespace
}  // namespace m100::core
