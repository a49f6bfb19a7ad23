// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/est/filter/acceleration_history.h"
#include "firmware/est/filter/kalman.h"
#include "firmware/est/filter/pose_agreement.h"
#include "firmware/est/filter/pose_gate.h"
#include "firmware/est/filter/response_step.h"
#include "firmware/model/vehicle.h"

namespace m100::est {

/// Model that the filter of one horizontal axis uses.
struct AxisModel {
  model::StickAxis attitude;  ///< dynamics of the tilt; the caller of predict() applies the delay
  double tilt_sign = 1.0;     ///< +1: x'' = +g tan(tilt); -1: y'' = -g tan(tilt)
  double tilt_gain = 1.0;
  double linear_drag_per_s = 0.0;
  double quadratic_drag_per_m = 0.0;
  model::EstimatorNoise noise;

  static AxisModel of(const model::Vehicle& vehicle, const model::StickAxis& axis, double sign) {
    return {.attitude = axis,
            .tilt_sign = sign,
            .tilt_gain = vehicle.translation.tilt_gain,
            .linear_drag_per_s = vehicle.translation.linear_drag_per_s,
            .quadratic_drag_per_m = vehicle.translation.quadratic_drag_per_m,
            .noise = model::flown_noise(vehicle)};
  }
};

/// What happened to a measurement.
enum class FusionResult : std::uint8_t { kUsed, kRefused };

/// Extended Kalman filter of one horizontal axis, with the disturbance (paper, III-E.1: "augmented EKF based on the
/// second order dynamics model"). derivation/derive.py derives and prints it.
///
/// State x = (p [m], v [m/s], tilt [rad], rate [rad/s], d [m/s^2], m [rad]); T is the tick, g signed and with its gain:
///   acc   = g tan(tilt) + g / (2 cos^2 tilt) (tilt+ - tilt) - c v - c2 |v| v
///   p+    = p + T v + T^2/2 (acc + d)
///   v+    = v + T (acc + d)
///   tilt+ = oo tilt + o_r rate + o_u (u + m) + o_jump (u - u_before)                 (model::AxisStep)
///   rate+ = ro tilt + rr rate + r_u (u + m) + r_next (u_next + m) + r_jump (u - u_before)
///   d+    = d, m+ = m  (random walks; paper, Eq. (2): d_{k+1} = d_k)
/// d acts as an acceleration (wind); m acts at the input (trim, command gain, offset of the attitude loop); u is the
/// command that acts now (the caller delays it). With k = T g / (2 cos^2 tilt), b = T (c + 2 c2 |v|), r_m = r_u +
/// r_next:
///       | 1   T - T/2 b   T/2 k (1 + oo)   T/2 k o_r   T^2/2   T/2 k o_u |
///       | 0   1 - b           k (1 + oo)       k o_r   T           k o_u |
///   F = | 0   0           oo               o_r         0       o_u       |     Q = T diag(process noise^2)
///       | 0   0           ro               rr          0       r_m       |
///       | 0   0           0                0           1       0         |
///       | 0   0           0                0           0       1         |
/// Measurements, each a scalar one of a time a ago:
///   position   H = (1, -a, 0, 0, a^2/2, 0)   R: vehicle file or sender; the accelerations since then are stored
///   tilt       H = (0, 0, 1, -a, 0, 0)       R = attitude_sigma^2
///   tilt rate  H = (0, 0, 0, 1, 0, 0)        R = rate_sigma^2
/// Ranges, enforced: |p| <= 100 m, |v| <= 25 m/s, |tilt| <= 0.7 rad, |rate| <= 10 rad/s, |d| <= 8 m/s^2, |m| <= 0.3
/// rad.
///
/// S is double, float or core::Fixed. Cost per predict and three corrections: firmware/RESULTS.md.
template <typename S>
class AxisFilter {
 public:
  static constexpr int kStates = 6;
  enum StateIndex : int { kP, kV, kTilt, kRate, kD, kM };

  explicit AxisFilter(const AxisModel& model);

  /// Starts with a measured tilt; the other states start at 0. reset_position() follows.
  void start(S tilt_rad);
  /// Advances one tick; commands in rad.
  void predict(const ActingInputs<S>& command_rad);
  /// How a measured disturbance is used.
  enum class DisturbanceUse : std::uint8_t { kStored, kHeld, kTracked };
  /// Fuses the disturbance that the specific force shows, after removing the drag of the model.
  ///   kStored   stores it as the reference that belongs to the present d
  ///   kTracked  changes d as the measured value has changed since it was last stored, limits d to within
  ///             kForceOffset_m_s2 of the measured value, and stores that value
  ///   kHeld     does nothing
  void fuse_specific_force(S disturbance_m_s2, DisturbanceUse use);
  /// Fuses tilt and tilt rate of `age_s` ago; refuses both if either is outside its gate.
  FusionResult fuse_attitude(S tilt_rad, S rate_rad_s, S age_s);

  /// Innovation of a position of `age_s` ago, at most kMaxPoseAge_s, and whether it is inside the gate (inside_gate()).
  /// @param unseen_m innovations up to this distance pass the gate whatever the sigmas are
  /// @param sender_variance_m2 used if larger than the vehicle file's variance
  PoseInnovation<S> test_pose(S position_m, S age_s, S unseen_m, S sender_variance_m2) const;
  void fuse_pose(const PoseInnovation<S>& test);
  /// Sets the position (of `age_s` ago) and the velocity, with no covariances. Their variances are the initial ones, or
  /// those of the poses that gave them if these are larger, up to the squares of their ranges. The other states stay.
  void reset_position(S position_m, S velocity_m_s, S age_s, const MotionVariance& variance);

  /// The tilt that the model predicts from the commands alone, without measurements; rad.
  S model_tilt() const { return model_response_.output; }
  /// See DisturbanceEkf.
  void reduce_input_offset(S share) { filter_.x(kM) -= share * filter_.x(kM); }
  S state(StateIndex i) const { return filter_.x(i); }
  S covariance(int row, int col) const { return filter_.p(row, col); }
  /// Whether all states are numbers and all variances are positive.
  bool is_sane() const;

 private:
  S drag(S velocity_m_s) const;

  Kalman<S, kStates> filter_;
  S stored_disturbance_{0};  ///< measured disturbance as last stored, less the model's drag
  S angular_acceleration_{0};
  ResponseStep<S> response_;
  typename ResponseStep<S>::State model_response_;  ///< from commands and model alone
  S rate_per_offset_;                               ///< r_m
  S gravity_, linear_drag_, quadratic_drag_;
  S pose_variance_, tilt_variance_, rate_variance_;
  core::Vector<S, kStates> q_;
  AccelerationHistory<S> history_;
};

}  // namespace m100::est
