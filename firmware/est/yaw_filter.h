// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "firmware/est/delayed_pose.h"
#include "firmware/est/scaled_covariance.h"

namespace m100::est {

/// Heading in the world of the pose source, carried by the gyro: yaw' = gyro - bias, bias' = 0. Inside, time counts in
/// 0.64 s. Measured: yaw of `age` ago. yaw is in (-pi, pi], |bias| <= 0.2 rad/s.
template <typename S>
class YawFilter {
 public:
  using Covariance = ScaledCovariance<S, 2>;
  explicit YawFilter(double yaw_sigma_rad);
  void start(S yaw);
  /// One tick on at a measured yaw rate, rad per unit.
  void predict(S yaw_rate);
  /// Innovation of a yaw of `age` ago, in (-pi, pi].
  S innovation(S yaw, const Age<S>& age);
  void correct(S innovation, const Age<S>& age);
  void reanchor(S yaw);
  S yaw() const { return yaw_; }
  /// Of the gyro less its bias, rad per unit.
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
