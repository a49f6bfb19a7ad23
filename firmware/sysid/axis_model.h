// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "firmware/model/vehicle.h"

namespace m100::sysid {

/// One stick axis as it may be simulated and fitted: everything the vehicle file can say of it and the effects that
/// identification may add. Zero means "no such effect", except where another neutral value is given. The unit of the
/// axis is rad (roll, pitch), rad/s (yaw rate) or m/s (climb).
///
///   v = play(u) - trim                                    u stick in counts from neutral
///   c = (1 + drift t) (A(v) curve(dead_zone(v)) + gain cross_axis u_other)      A the gain of the stick's side
///   a = slew(limit(c)) delay_s ago
///   y'' = w^2 (a + lead_zero a' - y) - 2 z w y'           second order
///   y'  = (a - y) / time_constant                         first order
template <typename Real>
struct AxisModel {
  Real gain = Real(0);             ///< unit of the axis per count
  Real time_constant_s = Real(0);  ///< first order if and only if > 0
  Real natural_frequency_rad_s = Real(0);
  Real damping_ratio = Real(0);
  Real delay_s = Real(0);
  Real lead_zero_s = Real(0);
  Real dead_zone_counts = Real(0);  ///< half width
  model::DeadZoneShape dead_zone_shape = model::DeadZoneShape::kContinuous;
  Real trim_counts = Real(0);
  Real stick_exponent = Real(1);
  Real backlash_counts = Real(0);     ///< half width
  Real saturation = Real(0);          ///< |command| limit, unit of the axis
  Real tilt_limit = Real(0);          ///< limit of the vector of both axes' commands, unit of the axis
  Real other_gain = Real(0);          ///< unit per count of the other axis, for the tilt limit; 0: same as gain
  Real rate_limit_per_s = Real(0);    ///< |y'| limit
  Real command_slew_per_s = Real(0);  ///< |a'| limit: the other place where a rate may be limited
  Real gain_asymmetry = Real(1);      ///< gain for positive over gain for negative sticks; their mean is `gain`
  Real gain_drift_per_s = Real(0);
  Real cross_axis = Real(0);  ///< share of the other stick that arrives here
};

/// The believed axis of a vehicle file as a model to simulate.
AxisModel<double> to_axis_model(const model::AttitudeAxis& axis);
AxisModel<double> to_axis_model(const model::RateAxis& axis);

/// Stick counts to command in the unit of the axis: everything before delay and dynamics. Keeps the play of the
/// backlash and the slewed command between calls. Cost: some 30 flops, one power where there is a stick curve.
template <typename Real>
class StaticLaw {
 public:
  StaticLaw(const AxisModel<Real>& model, Real sample_period_s);
  /// The next sample. Sticks are counts from neutral, `t_s` counts from where the gain drift is nought.
  Real command(Real stick_counts, Real other_counts, Real t_s);

 private:
  Real dead_zone_and_curve(Real counts) const;
  AxisModel<Real> model_;
  Real slew_per_sample_;
  Real positive_gain_;
  Real negative_gain_;
  Real play_counts_ = Real(0);
  Real slewed_ = Real(0);
  bool started_ = false;
};

/// Command to response, exact for a command held over one sample period. Second order: state (y, y').
template <typename Real>
class AxisDynamics {
 public:
  /// Requires time_constant_s > 0 or natural_frequency_rad_s in (0, 0.5 / sample period] and damping_ratio in [0, 5].
  AxisDynamics(const AxisModel<Real>& model, Real sample_period_s);
  void start(Real value, Real rate_per_s);
  /// Holds `command` for one sample period.
  /// @returns the response at its end.
  Real step(Real command) {
    const Real before = value_;
    if (first_order_) {
      value_ = command + a11_ * (value_ - command);
      if (limit_per_s_ > Real(0)) {
        value_ = limited(before, value_);
      }
      return value_;
    }
    const Real offset = value_ - command;
    value_ = command + a11_ * offset + a12_ * rate_per_s_;
    rate_per_s_ = a21_ * offset + a22_ * rate_per_s_;
    if (limit_per_s_ > Real(0)) {
      limit_rate(before);
    }
    return value_;
  }
  Real value() const { return value_; }
  Real rate_per_s() const { return rate_per_s_; }

 private:
  Real limited(Real before, Real after) const;
  void limit_rate(Real before);
  bool first_order_;
  Real sample_period_s_;
  Real limit_per_s_;
  Real a11_ = Real(0), a12_ = Real(0), a21_ = Real(0), a22_ = Real(0);
  Real value_ = Real(0), rate_per_s_ = Real(0);
};

/// x^exponent for 0 <= x <= 8, 0.1 <= exponent <= 10, by + - * / alone (promise R6). Relative error below 1e-12.
template <typename Real>
Real power(Real x, Real exponent);

}  // namespace m100::sysid
