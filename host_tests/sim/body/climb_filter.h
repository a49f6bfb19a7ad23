// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace m100::sim {

/// The autopilot's climb speed: a third-order complementary filter of accelerometer and barometer with all poles at
/// -1/T. It follows the accelerometer above 1/T, the barometer below, and finds the accelerometer's bias.
class ClimbFilter {
 public:
  /// @param time_constant_s  T
  explicit ClimbFilter(double time_constant_s) : time_constant_s_(time_constant_s) {}
  void reset(double height_m) {
    height_m_ = height_m;
    climb_m_s_ = bias_m_s2_ = 0.0;
  }
  void update(double acceleration_m_s2, double barometer_m, double step_s) {
    const double error_m = barometer_m - height_m_;
    const double pole = 1.0 / time_constant_s_;
    const double acceleration = acceleration_m_s2 + bias_m_s2_ + 3.0 * pole * pole * error_m;
    height_m_ += step_s * (climb_m_s_ + 0.5 * step_s * acceleration + 3.0 * pole * error_m);
    climb_m_s_ += step_s * acceleration;
    bias_m_s2_ += step_s * pole * pole * pole * error_m;
  }
  double climb_m_s() const { return climb_m_s_; }

 private:
  double time_constant_s_;
  double height_m_ = 0.0;
  double climb_m_s_ = 0.0;
  double bias_m_s2_ = 0.0;
};

}  // namespace m100::sim
