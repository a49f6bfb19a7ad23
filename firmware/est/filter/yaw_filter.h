// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/est/filter/acceleration_history.h"
#include "firmware/est/filter/scaled_covariance.h"

namespace m100::est {

/// Kalman filter of the heading in the world of the pose source, predicted by the gyro: yaw' = gyro - bias, bias' = 0.
/// The internal time unit is 0.64 s. Measurement: yaw of `age` ago. yaw is in (-pi, pi], |bias| <= 0.2 rad/s.
template <typename S>
class YawFilter {
 public:
  using Covariance = ScaledCovariance<S, 2>;
  explicit YawFilter(double yaw_sigma_rad);
  void start(S yaw);
  /// Advances one tick at a measured yaw rate, rad per unit.
  void predict(S yaw_rate);
  /// Innovation of a yaw of `age` ago, in (-pi, pi].
  S innovation(S yaw, const MeasurementAge<S>& age);
  void correct(S innovation, const MeasurementAge<S>& age);
  void reset_position(S yaw);
  S yaw() const { return yaw_; }
  /// Gyro rate less its bias, rad per unit.
  S yaw_rate() const { return rate_; }
  bool is_sane() const;
  CovarianceHealth health() const { return covariance_.health(); }

 private:
  S wrapped(S angle);

  S yaw_{}, bias_{}, rate_{};
  S variance_{};
  typename Covariance::Matrix phi_{};
  typename Covariance::Column q_{};
  Covariance covariance_;
};

}  // namespace m100::est
