// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "firmware/est/filter/acceleration_history.h"
#include "firmware/est/filter/filter_math.h"
#include "firmware/est/filter/scaled_covariance.h"

namespace m100::est {

/// Kalman filter of height z, climb speed w, rate of change of w, and climb offset b: in steady flight, the flown climb
/// speed minus the commanded one.
///   z' = w, w follows (u + b) as the climb axis of the vehicle file does (model::AxisStep), u the command, b' = 0
/// The internal time unit is 0.64 s. The measurement is the height `age` ago. Ranges: |z| <= 100 m, |w| <= 10 m/s, |w'|
/// <= 50 m/s^2, |b| <= 1 m/s.
template <typename S>
class HeightFilter {
 public:
  static constexpr int kStates = 4;
  enum StateIndex : int { kZ, kClimb, kRate, kOffset };
  static constexpr int kHeightScale = -5;
  using Covariance = ScaledCovariance<S, kStates>;

  HeightFilter(const model::StickAxis& climb, double pose_sigma_m);
  void start();  ///< all states at 0; reset_position() follows
  /// Commands: climb speed in m per unit.
  void predict(const ActingInputs<S>& input);
  struct PoseInnovation {
    typename Covariance::Projection projection;
    S innovation{};
    S noise{};      ///< variance of the pose
    int scale = 0;  ///< the variances projection.s and noise are in units of 4^scale m^2
    bool inside = false;
  };
  PoseInnovation test_pose(S height, const MeasurementAge<S>& age, S unseen_m, float sender_variance_m2);
  void fuse_pose(const PoseInnovation& test);
  void reset_position(S height, S climb, const MeasurementAge<S>& age, const MotionVariance& variance);
  S state(StateIndex i) const { return x_[static_cast<std::size_t>(i)]; }
  S gain() const { return gain_; }
  S climb_gain() const { return climb_gain_; }
  /// Variance of the height at the newest pose that was used, in units of 4^kHeightScale m^2.
  S scaled_pose_height_variance() const { return pose_height_variance_; }
  bool is_sane() const;
  CovarianceHealth health() const { return covariance_.health(); }

 private:
  void clamp_states();

  std::array<S, kStates> x_{};
  ResponseStep<S> response_;
  S pose_variance_{};
  S pose_rate_{};
  S pose_height_variance_{};
  S gain_{}, climb_gain_{};  ///< corrections of height and climb speed per innovation, of the newest pose
  typename Covariance::Matrix phi_{};
  typename Covariance::Column q_{};
  Covariance covariance_;
  AccelerationHistory<S> history_;
};

}  // namespace m100::est
