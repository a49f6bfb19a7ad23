// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/est/filter/kalman.h"

namespace m100::est {

/// Kalman filter of the heading in the world of the pose source, predicted by the gyro: yaw' = gyro - bias, bias' = 0.
/// Measurement: yaw of a time a ago, H = (1, a), because the bias has acted on the prediction during the age. yaw is in
/// (-pi, pi], |bias| <= 0.2 rad/s.
template <typename S>
class YawFilter {
 public:
  explicit YawFilter(double yaw_sigma_rad);
  void start(S yaw_rad);
  /// Advances one tick at a measured yaw rate.
  void predict(S yaw_rate_rad_s);
  /// Innovation of a yaw of `age_s` ago, in (-pi, pi].
  S innovation(S yaw_rad, S age_s) const;
  void correct(S innovation_rad, S age_s);
  void reset_yaw(S yaw_rad);
  S yaw() const { return filter_.x(kYaw); }
  /// Gyro rate less its bias, rad/s.
  S yaw_rate() const { return rate_; }
  bool is_sane() const;

 private:
  enum StateIndex : int { kYaw, kBias };

  Kalman<S, 2> filter_;
  S rate_{0};
  S variance_;
};

}  // namespace m100::est
