// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/core/frames.h"

namespace m100::sim {

/// The autopilot's attitude: a complementary filter on the rotation group (Mahony, Hamel and Pflimlin, IEEE TAC 2008,
/// explicit form with bias), gyro and accelerometer, and a compass for the heading. World NWU, body FLU.
///
///   e   = f/|f| x R' e_z     f the specific force; used while 0.5 g < |f| < 1.5 g
///   q'  = q (omega - b + k e) / 2,   b' = -k^2/4 e
class AttitudeFilter {
 public:
  /// @param accelerometer_gain_per_s  k
  explicit AttitudeFilter(double accelerometer_gain_per_s) : gain_per_s_(accelerometer_gain_per_s) {}

  /// Starts from a body at rest: level from the specific force, heading from the compass, bias from the gyro.
  void reset(const core::Vector<double, 3>& gyro_b_rad_s, const core::Vector<double, 3>& specific_force_b_m_s2,
             double heading_rad);
  void update(const core::Vector<double, 3>& gyro_b_rad_s, const core::Vector<double, 3>& specific_force_b_m_s2,
              double heading_rad, double step_s);

  const core::Quaternion<double>& rotation_wb() const { return rotation_wb_; }
  /// The gyro without its estimated bias.
  const core::Vector<double, 3>& rate_b_rad_s() const { return rate_b_rad_s_; }
  /// What the specific force leaves of the acceleration upwards, m/s^2.
  double vertical_acceleration_m_s2(const core::Vector<double, 3>& specific_force_b_m_s2) const;

 private:
  core::Vector<double, 3> up_b() const;

  double gain_per_s_;
  core::Quaternion<double> rotation_wb_{};
  core::Vector<double, 3> bias_b_rad_s_ = core::Vector<double, 3>::Zero();
  core::Vector<double, 3> rate_b_rad_s_ = core::Vector<double, 3>::Zero();
  core::Vector<double, 3> last_gyro_b_rad_s_ = core::Vector<double, 3>::Zero();
};

}  // namespace m100::sim
