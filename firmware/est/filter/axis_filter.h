// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/fixed_point.h"
#include "firmware/est/filter/acceleration_history.h"
#include "firmware/est/filter/filter_math.h"
#include "firmware/est/filter/scaled_covariance.h"
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
};

/// What happened to a measurement.
enum class FusionResult : std::uint8_t { kUsed, kRefused };

/// Extended Kalman filter of one horizontal axis, with the disturbance (paper, III-E.1: "augmented EKF based on the
/// second order dynamics model").
///
/// State x (6x1): p [m], v [m/s], tilt [rad], tilt rate [rad/s], d [m/s^2], m [rad]; the internal time unit is 0.64 s.
///   p'    = v
///   v'    = +-tilt_gain g tan(tilt) - c v - c2 |v| v + d
///   tilt  : model::AxisStep of (u + m), u the command that acts now (the caller delays it)
///   d' = 0, m' = 0 (random walks; paper, Eq. (2): d_{k+1} = d_k)
/// d acts as an acceleration (wind); m acts at the input (trim, command gain, offset of the attitude loop).
/// Measurements: position of `age` ago, tilt and tilt rate of `age` ago, each as a scalar update.
///
/// S is double, float or core::Fixed; the same source, the same order of operations. Ranges, enforced: |p| <= 100 m,
/// |v| <= 25 m/s, |tilt| <= 0.7 rad, |rate| <= 10 rad/s, |d| <= 8 m/s^2, |m| <= 0.3 rad.
/// Cost per predict and three corrections: firmware/RESULTS.md.
template <typename S>
class AxisFilter {
 public:
  static constexpr int kStates = 6;
  enum StateIndex : int { kP, kV, kTilt, kRate, kD, kM };
  using Scales = std::array<int, kStates>;

  /// Scales the covariance by steady_scales() of this model.
  explicit AxisFilter(const AxisModel& model);
  AxisFilter(const AxisModel& model, const Scales& scales);

  /// Starts with a measured tilt; the other states start at 0. reset_position() follows.
  void start(S tilt);
  /// Advances one tick; commands in rad.
  void predict(const ActingInputs<S>& input);
  /// How a measured disturbance is used.
  enum class DisturbanceUse : std::uint8_t { kStored, kHeld, kTracked };
  /// Fuses the disturbance that the specific force shows (m per unit squared), after removing the drag of the model.
  ///   kStored   stores it as the reference that belongs to the present d
  ///   kTracked  changes d as the measured value has changed since it was last stored, limits d to within
  ///             kForceOffset_m_s2 of the measured value, and stores that value
  ///   kHeld     does nothing
  void fuse_specific_force(S disturbance, DisturbanceUse use);
  /// Fuses tilt (rad) and tilt rate (rad per unit) of `age` ago; refuses both if either is outside its gate.
  FusionResult fuse_attitude(S tilt, S rate, const MeasurementAge<S>& age);

  /// Innovation of a position (m) of `age` ago, and whether it is inside the gate (inside_gate()).
  struct PoseInnovation {
    typename ScaledCovariance<S, kStates>::Projection projection;
    S innovation{};
    S noise{};      ///< variance of the pose
    int scale = 0;  ///< the variances projection.s and noise are in units of 4^scale m^2
    bool inside = false;
    /// The square of the innovation over its variance; its expectation is 1.
    float normalised_square() const {
      using Number = core::Arithmetic<S>;
      const auto scaled = Number::template real<float>(innovation) * power_of_two<float>(-scale);
      return scaled * scaled / Number::template real<float>(projection.s);
    }
  };
  /// @param unseen_m innovations up to this distance pass the gate whatever the sigmas are
  /// @param sender_variance_m2 used if larger than the vehicle file's variance; 0: none
  PoseInnovation test_pose(S position, const MeasurementAge<S>& age, S unseen_m, float sender_variance_m2);
  void fuse_pose(const PoseInnovation& test);
  void check() { covariance_.check(); }  ///< once after the corrections of a tick: keeps the covariance valid
  /// Sets the position (of `age` ago) and the velocity, with no covariances. Their variances are the initial ones, or
  /// those of the poses that gave them if these are larger. The other states stay.
  void reset_position(S position, S velocity, const MeasurementAge<S>& age, const MotionVariance& variance);

  /// The tilt that the model predicts from the commands alone, without measurements; rad.
  S model_tilt() const { return model_response_.output; }
  /// See DisturbanceEkf.
  void reduce_input_offset(S share) {
    auto& a = covariance_.arithmetic();
    x_[kM] = a.narrow(a.widen(x_[kM]) - a.product(share, x_[kM]));
  }
  S state(StateIndex i) const { return x_[static_cast<std::size_t>(i)]; }
  /// Covariance of two states in scaled units: P / 2^(scale of row + scale of col); see ScaledCovariance.
  S scaled_covariance(int row, int col) const { return covariance_(row, col); }
  const Scales& scales() const { return scales_; }
  CovarianceHealth health() const { return covariance_.health(); }
  /// Whether all states are inside their ranges and all variances are valid.
  bool is_sane() const;

 private:
  struct Coefficients {
    S gravity{}, half_gravity{}, drag{}, square_drag{};
    // For the scaled covariance: d(v+)/d(tilt, rate, m) = v_* / cos^2, d(v+)/d(v) = tick_drag - tick_square_drag |v|.
    S v_tilt{}, v_rate{}, v_m{}, tick_drag{}, tick_square_drag{};
    S pose_variance{}, tilt_variance{}, rate_variance{};
    S pose_rate{}, pose_d{}, tilt_rate{};
  };
  void clamp_states();
  void apply(const typename ScaledCovariance<S, kStates>::Column& gain, S innovation, int measured);

  std::array<S, kStates> x_{};
  S stored_disturbance_{};  ///< measured disturbance as last stored, less the model's drag
  S angular_acceleration_{};
  ResponseStep<S> response_;
  typename ResponseStep<S>::State model_response_;  ///< from commands and model alone
  Coefficients c_;
  typename ScaledCovariance<S, kStates>::Matrix phi_{};
  typename ScaledCovariance<S, kStates>::Column q_{};
  Scales scales_{};
  ScaledCovariance<S, kStates> covariance_;
  AccelerationHistory<S> history_;
};

/// Exponents of the covariance scales: 2^exponent is 4 to 8 times the steady-state sigma of the state, in units of the
/// filter. They come from a simulation of the filter over 5 s. It takes about 2 ms on a desktop core; call it at
/// start-up only.
template <typename S>
typename AxisFilter<S>::Scales steady_scales(const AxisModel& model);

}  // namespace m100::est
