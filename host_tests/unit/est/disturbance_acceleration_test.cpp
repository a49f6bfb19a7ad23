// SPDX-License-Identifier: BSD-3-Clause
// Without a pose the observer uses the specific force to predict the push (Measurement::push).
#include <gtest/gtest.h>

#include <cmath>

#include "firmware/est/filter/disturbance_ekf.h"
#include "host_tests/unit/est/scalars.h"

namespace m100::est {
namespace {

template <typename T>
class MeasuredDisturbance : public ::testing::Test {};
TYPED_TEST_SUITE(MeasuredDisturbance, Scalars);

constexpr double kDrag_per_s = 0.3;
constexpr double kSpeed_m_s = 4.0;
constexpr double kPosesFor_s = 4.0;
constexpr double kLag_s = 0.2;  // lag of the attitude

/// The flight: a steady speed against the drag, then braking from the last pose on.
struct Brake {
  double believed_drag_per_s = 0.01;
  bool force_comes = true;
  double force_offset_m_s2 = 0.0;
};

/// @returns the error of the estimated velocity 1.5 s after the last pose, m/s.
template <typename TypeParam>
double error_m_s(const Brake& brake) {
  using Real = typename TypeParam::Real;
  model::Vehicle vehicle;
  vehicle.climb.time_constant_s = 0.334;
  vehicle.pitch.time_constant_s = kLag_s;
  vehicle.translation.linear_drag_per_s = brake.believed_drag_per_s;
  typename TypeParam::Filter filter(vehicle);
  double tilt_rad = std::atan(kDrag_per_s * kSpeed_m_s / 9.8066);
  double x_m = 0.0, v_m_s = kSpeed_m_s, mean_m_s2 = -kDrag_per_s * kSpeed_m_s;
  Estimate<Real> estimate;
  for (int tick = 0; tick < static_cast<int>(100.0 * (kPosesFor_s + 1.5)); ++tick) {
    const bool seen = 0.01 * tick < kPosesFor_s;
    const double command_rad = seen ? std::atan(kDrag_per_s * kSpeed_m_s / 9.8066) : -0.2;
    const double rate_rad_s = (command_rad - tilt_rad) / kLag_s;
    tilt_rad += 0.01 * rate_rad_s;
    const double disturbance_acceleration_m_s2 = -kDrag_per_s * v_m_s;
    v_m_s += 0.01 * (9.8066 * std::tan(tilt_rad) + disturbance_acceleration_m_s2);
    x_m += 0.01 * v_m_s;
    mean_m_s2 += 0.1 * (disturbance_acceleration_m_s2 - mean_m_s2);
    Measurement<Real> m;
    m.now = core::TimePoint(std::chrono::milliseconds(10 * tick));
    m.attitude.is_new = true;
    m.attitude.pitch_rad = static_cast<Real>(tilt_rad);
    m.attitude.rate_b_rad_s.y() = static_cast<Real>(rate_rad_s);
    m.disturbance_acceleration.is_known = brake.force_comes;
    m.disturbance_acceleration.mean_w_m_s2.x() = static_cast<Real>(mean_m_s2 + brake.force_offset_m_s2);
    m.pose.is_new = seen;
    m.pose.arrived = m.now;
    m.pose.position_w_m = {static_cast<Real>(x_m), Real(0), Real(1)};
    m.pose.set_captured_at(m.now);
    estimate = filter.update(m, {.pitch_rad = static_cast<Real>(command_rad)}, core::kTickPeriod);
  }
  return std::abs(static_cast<double>(estimate.x.velocity_m_s) - v_m_s);
}

// Catches a prediction that keeps the drag of a speed that braking has already removed: the error is 0.5 m/s after 1.5
// s, and the aircraft stops outside its fence.
TYPED_TEST(MeasuredDisturbance, TakesTheDragAwayWithTheSpeed) {
  EXPECT_LT(error_m_s<TypeParam>({}), 0.12);
  EXPECT_GT(error_m_s<TypeParam>({.force_comes = false}), 0.4) << "what this test is about";
}

// Catches a force that is used without removing its offset: an offset of 0.1 or 0.2 m/s^2 is normal.
TYPED_TEST(MeasuredDisturbance, AnOffsetOfTheForceChangesNothing) {
  EXPECT_NEAR(error_m_s<TypeParam>({.force_offset_m_s2 = 0.1}), error_m_s<TypeParam>({}), 0.03);
  EXPECT_NEAR(error_m_s<TypeParam>({.force_offset_m_s2 = -0.1}), error_m_s<TypeParam>({}), 0.03);
}

// Catches a drag that is counted twice, from the vehicle file and from the force.
TYPED_TEST(MeasuredDisturbance, DragThatTheVehicleFileKnowsIsNotTakenTwice) {
  EXPECT_LT(error_m_s<TypeParam>({.believed_drag_per_s = kDrag_per_s}), 0.12);
}

}  // namespace
}  // namespace m100::est
