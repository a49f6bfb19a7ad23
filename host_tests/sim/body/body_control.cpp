// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/body_control.h"

#include <algorithm>
#include <cmath>

#include "firmware/model/vehicle.h"

namespace m100::sim {
namespace {

using Vector3 = core::Vector<double, 3>;

constexpr double kMinHover = 0.05;
constexpr double kMaxHover = 0.9;
constexpr double kMaxIntegral_rad_s = 1.0;
constexpr double kMinCosine = 0.5;  // beyond 60 degrees of tilt the thrust is not raised further

/// Body rates that turn the z-y-x angles at these rates.
Vector3 body_rates(const core::Euler<double>& angles, const Vector3& angle_rates) {
  const double sr = std::sin(angles.roll_rad), cr = std::cos(angles.roll_rad);
  const double sp = std::sin(angles.pitch_rad), cp = std::cos(angles.pitch_rad);
  return {angle_rates.x() - sp * angle_rates.z(), cr * angle_rates.y() + sr * cp * angle_rates.z(),
          -sr * angle_rates.y() + cr * cp * angle_rates.z()};
}

}  // namespace

Vector3 BodyControl::angular_acceleration(const BodyCommand& command, const BodyMotion& motion, double step_s) {
  const auto limited = [](double rate_rad_s) { return std::clamp(rate_rad_s, -kMaxRate_rad_s, kMaxRate_rad_s); };
  const Vector3 angle_rates(limited(numbers_.attitude_gain_per_s * (command.roll_rad - motion.attitude.roll_rad)),
                            limited(numbers_.attitude_gain_per_s * (command.pitch_rad - motion.attitude.pitch_rad)),
                            command.yaw_rate_rad_s);
  const Vector3 error = body_rates(motion.attitude, angle_rates) - motion.rate_b_rad_s;
  if (motion.in_air) {
    integral_rad_s_ += step_s / numbers_.rate_integral_s * error;
    integral_rad_s_ = integral_rad_s_.cwiseMax(-kMaxIntegral_rad_s).cwiseMin(kMaxIntegral_rad_s);
  } else {
    integral_rad_s_.setZero();
  }
  const Vector3 gains(numbers_.rate_gain_per_s, numbers_.rate_gain_per_s, numbers_.yaw_rate_gain_per_s);
  // The derivative below the cutoff is the cutoff times what the low-pass leaves out.
  slow_rate_rad_s_ += (1.0 - std::exp(-kRateCutoff_rad_s * step_s)) * (motion.rate_b_rad_s - slow_rate_rad_s_);
  const double derivative = numbers_.rate_derivative_s * kRateCutoff_rad_s;
  const Vector3 damping = Vector3(derivative, derivative, 0.0).cwiseProduct(motion.rate_b_rad_s - slow_rate_rad_s_);
  return gains.cwiseProduct(error + integral_rad_s_ - damping);
}

RotorNumbers BodyControl::update(const BodyCommand& command, const BodyMotion& motion, double step_s) {
  const Vector3 acceleration = angular_acceleration(command, motion, step_s);
  const double error_g = numbers_.climb_gain_per_s * (command.climb_m_s - motion.climb_m_s) / model::kGravity_m_s2;
  const double cosine = std::cos(motion.attitude.roll_rad) * std::cos(motion.attitude.pitch_rad);
  const double collective = std::max(0.0, hover_ * (1.0 + error_g) / std::max(kMinCosine, cosine));
  const bool is_full = (collective >= 1.0 && error_g > 0.0) || (collective <= 0.0 && error_g < 0.0);
  const bool lifts_off = command.climb_m_s > 0.0;
  if ((motion.in_air || lifts_off) && !is_full) {
    hover_ = std::clamp(hover_ * (1.0 + step_s / numbers_.hover_learning_s * error_g), kMinHover, kMaxHover);
  }
  RotorNumbers throttle = RotorMixer::mix({.collective = motion.in_air || lifts_off ? collective : 0.0,
                                           .roll = hover_ * acceleration.x() / numbers_.roll_authority_rad_s2,
                                           .pitch = hover_ * acceleration.y() / numbers_.pitch_authority_rad_s2,
                                           .yaw = hover_ * acceleration.z() / numbers_.yaw_authority_rad_s2});
  for (double& rotor : throttle) {
    rotor = throttle_of(rotor, numbers_.thrust_curve);
  }
  return throttle;
}

}  // namespace m100::sim
