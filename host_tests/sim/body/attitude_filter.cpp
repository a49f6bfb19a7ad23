// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/sim/body/attitude_filter.h"

#include <cmath>

#include "firmware/model/vehicle.h"

namespace m100::sim {
namespace {

using Vector3 = core::Vector<double, 3>;
using Rotation = core::Quaternion<double>;

constexpr double kHeadingGain_per_s = 0.2;  // to the compass: slow against every turn, fast against a gyro's drift

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}

/// q turned by a small rotation of the body, with the length 1.
Rotation turned(const Rotation& q, const Vector3& angle_b_rad) {
  const double x = 0.5 * angle_b_rad.x(), y = 0.5 * angle_b_rad.y(), z = 0.5 * angle_b_rad.z();
  Rotation r{.w = q.w - q.x * x - q.y * y - q.z * z,
             .x = q.x + q.w * x + q.y * z - q.z * y,
             .y = q.y + q.w * y + q.z * x - q.x * z,
             .z = q.z + q.w * z + q.x * y - q.y * x};
  const double length = std::sqrt(r.w * r.w + r.x * r.x + r.y * r.y + r.z * r.z);
  return {r.w / length, r.x / length, r.y / length, r.z / length};
}

}  // namespace

Vector3 AttitudeFilter::up_b() const {
  const Rotation& q = rotation_wb_;
  return {2.0 * (q.x * q.z - q.w * q.y), 2.0 * (q.y * q.z + q.w * q.x), 1.0 - 2.0 * (q.x * q.x + q.y * q.y)};
}

void AttitudeFilter::reset(const Vector3& gyro_b_rad_s, const Vector3& specific_force_b_m_s2, double heading_rad) {
  const Vector3& f = specific_force_b_m_s2;
  rotation_wb_ = core::quaternion_of(core::Euler<double>{.roll_rad = std::atan2(f.y(), f.z()),
                                                         .pitch_rad = std::atan2(-f.x(), std::hypot(f.y(), f.z())),
                                                         .yaw_rad = heading_rad});
  bias_b_rad_s_ = gyro_b_rad_s;
  last_gyro_b_rad_s_ = gyro_b_rad_s;
  rate_b_rad_s_.setZero();
}

void AttitudeFilter::update(const Vector3& gyro_b_rad_s, const Vector3& specific_force_b_m_s2, double heading_rad,
                            double step_s) {
  const Vector3 up = up_b();
  Vector3 error = Vector3::Zero();
  const double force = specific_force_b_m_s2.norm() / model::kGravity_m_s2;
  if (force > 0.5 && force < 1.5) {
    error = cross(specific_force_b_m_s2.normalized(), up);
  }
  bias_b_rad_s_ -= step_s * 0.25 * gain_per_s_ * gain_per_s_ * error;
  const double heading_error_rad = core::wrap_pi(heading_rad - core::yaw_of(rotation_wb_));
  const Vector3 between = 0.5 * (gyro_b_rad_s + last_gyro_b_rad_s_) - bias_b_rad_s_;
  const Vector3 correction = gain_per_s_ * error + kHeadingGain_per_s * heading_error_rad * up;
  rotation_wb_ = turned(rotation_wb_, step_s * (between + correction));
  last_gyro_b_rad_s_ = gyro_b_rad_s;
  rate_b_rad_s_ = gyro_b_rad_s - bias_b_rad_s_;
}

double AttitudeFilter::vertical_acceleration_m_s2(const Vector3& specific_force_b_m_s2) const {
  return up_b().dot(specific_force_b_m_s2) - model::kGravity_m_s2;
}

}  // namespace m100::sim
