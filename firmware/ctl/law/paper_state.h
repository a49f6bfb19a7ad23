// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/maths.h"
#include "firmware/est/estimate.h"
#include "firmware/model/paper.h"
#include "firmware/ref/window.h"

namespace m100::ctl {

/// The state of the law of the paper's authors, made from our observer's (mav_control_rw, January 2017):
///   tilt is the measured one, the input has no offset, and the disturbance is the observer's less Ki times the
///   integral of the position's error. The integral is limited, and 0 while the error is longer than
///   paper::kIntegralBall_m.
template <typename T>
class PaperState {
 public:
  void update(const est::Estimate<T>& estimate, const ref::Window<T>& reference, T step_s) {
    const T error_x_m = reference.x[0].position_m - estimate.x.position_m;
    const T error_y_m = reference.y[0].position_m - estimate.y.position_m;
    const T error_z_m = reference.height.position_m - estimate.height_m;
    constexpr T kBall_m = static_cast<T>(model::paper::kIntegralBall_m);
    const T size_m2 = error_x_m * error_x_m + error_y_m * error_y_m + error_z_m * error_z_m;
    const bool is_near = size_m2 < kBall_m * kBall_m;  // false for a number that is none, which must not stay
    integral_x_m_s_ = is_near ? limited(integral_x_m_s_ + step_s * error_x_m) : T(0);
    integral_y_m_s_ = is_near ? limited(integral_y_m_s_ + step_s * error_y_m) : T(0);
    x_ = state(estimate.x, integral_x_m_s_);
    y_ = state(estimate.y, integral_y_m_s_);
  }
  const est::AxisEstimate<T>& x() const { return x_; }
  const est::AxisEstimate<T>& y() const { return y_; }
  void reset() { integral_x_m_s_ = integral_y_m_s_ = T(0); }

 private:
  static T limited(T integral_m_s) {
    constexpr T kMax_m_s = static_cast<T>(model::paper::kIntegralLimit_m_s);
    return core::clamp(integral_m_s, -kMax_m_s, kMax_m_s);
  }
  static est::AxisEstimate<T> state(est::AxisEstimate<T> estimate, T integral_m_s) {
    estimate.tilt_rad = estimate.measured_tilt_rad;
    estimate.input_offset_rad = T(0);
    estimate.disturbance_m_s2 -= static_cast<T>(model::paper::kIntegralGain_per_s3) * integral_m_s;
    return estimate;
  }

  T integral_x_m_s_{0};
  T integral_y_m_s_{0};
  est::AxisEstimate<T> x_{};
  est::AxisEstimate<T> y_{};
};

/// The authors' law follows positions and velocities: their targets hold no acceleration.
template <typename T>
void remove_accelerations(ref::Window<T>& window) {
  window.height.acceleration_m_s2 = T(0);
  for (auto* const axis : {&window.x, &window.y}) {
    for (ref::AxisReference<T>& point : *axis) {
      point.acceleration_m_s2 = T(0);
    }
  }
}

}  // namespace m100::ctl
