// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/est/filter/acceleration_history.h"
#include "firmware/est/filter/kalman.h"
#include "firmware/est/filter/pose_agreement.h"
#include "firmware/est/filter/pose_gate.h"
#include "firmware/est/filter/response_step.h"

namespace m100::est {

/// Kalman filter of height z, climb speed w, rate of change of w, and climb offset b: in steady flight, the flown climb
/// speed minus the commanded one.
///   z' = w, w follows (u + b) as the climb axis of the vehicle file does (model::AxisStep), u the command, b' = 0
/// The measurement is the height a time a ago: H = (1, -a, 0, 0). Ranges: |z| <= 100 m, |w| <= 10 m/s, |w'| <= 50
/// m/s^2, |b| <= 1 m/s.
template <typename S>
class HeightFilter {
 public:
  static constexpr int kStates = 4;
  enum StateIndex : int { kZ, kClimb, kRate, kOffset };

  HeightFilter(const model::StickAxis& climb, double pose_sigma_m);
  void start();  ///< all states at 0; reset_position() follows
  /// Commands: climb speed in m/s.
  void predict(const ActingInputs<S>& input);
  PoseInnovation<S> test_pose(S height_m, S age_s, S unseen_m, S sender_variance_m2) const;
  void fuse_pose(const PoseInnovation<S>& test);
  void reset_position(S height_m, S climb_m_s, S age_s, const MotionVariance& variance);
  S state(StateIndex i) const { return filter_.x(i); }
  S gain() const { return gain_; }
  S climb_gain() const { return climb_gain_; }
  /// Variance of the height at the newest pose that was used.
  S pose_height_variance() const { return pose_height_variance_; }
  bool is_sane() const;

 private:
  Kalman<S, kStates> filter_;
  ResponseStep<S> response_;
  S pose_variance_{0};
  S pose_height_variance_{0};
  S gain_{0}, climb_gain_{0};  ///< corrections of height and climb speed per innovation, of the newest pose
  core::Vector<S, kStates> q_;
  AccelerationHistory<S> history_;
};

}  // namespace m100::est
