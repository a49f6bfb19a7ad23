// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "firmware/core/maths.h"
#include "firmware/model/paper.h"

namespace m100::model {

/// How a dead zone maps a stick outside of it.
enum class DeadZoneShape : std::uint8_t {
  kContinuous,  ///< counted from the edge: f(u) = sign(u) (|u| - w) for |u| > w
  kJump,        ///< f(u) = u for |u| > w
};

/// Parameters of one axis of the autopilot and of its response to its stick. The unit of the axis is rad (roll, pitch),
/// rad/s (yaw rate) or m/s (climb speed).
///
/// Stick to command: StickLaw. Command a to response y:
///   second order: y'' = w^2 (a + lead_zero a' - y) - 2 z w y', a the command of transport_delay_s ago
///   first order : y'  = (a + lead_zero a' - y) / time_constant_s
/// An axis is of first order if and only if time_constant_s > 0. A number at its default means that the effect is
/// absent.
struct StickAxis {
  double scale_per_count = 0.0;  ///< unit of the axis per count
  double time_constant_s = 0.0;
  double natural_frequency_rad_s = 0.0;
  double damping_ratio = 0.0;
  double transport_delay_s = 0.0;
  double lead_zero_s = 0.0;
  double dead_zone_counts = 0.0;  ///< half width
  DeadZoneShape dead_zone_shape = DeadZoneShape::kContinuous;
  double saturation = 0.0;             ///< |a| limit, unit of the axis
  double tilt_limit = 0.0;             ///< limit of the vector of both axes' commands, unit of the axis
  double other_scale_per_count = 0.0;  ///< scale of the other axis, for the tilt limit; 0: the same as this one's
  double rate_limit_per_s = 0.0;       ///< |y'| limit
  double command_slew_per_s = 0.0;     ///< |a'| limit: alternative place of a rate limit
  double gain_asymmetry = 1.0;         ///< gain for positive over gain for negative sticks; their mean is the scale
  double trim_counts = 0.0;            ///< trimmed neutral minus 1024; subtracted from the stick before the dead zone
  double stick_exponent = 1.0;         ///< f(u) = sign(u) 660 (|u| / 660)^exponent
  double backlash_counts = 0.0;        ///< half width of the stick's backlash
  double gain_drift_per_minute = 0.0;
  double cross_axis = 0.0;  ///< share of the other axis' stick that is added to this axis

  bool operator==(const StickAxis&) const = default;
  constexpr bool is_first_order() const { return time_constant_s > 0.0; }
  constexpr bool is_identified() const { return time_constant_s > 0.0 || natural_frequency_rad_s > 0.0; }
};

/// x^exponent for x <= 8 and 0.1 <= exponent <= 10 by + - * / only (promise R6), in double to 1e-11; 0 for x <= 1e-12.
template <typename Real>
Real power(Real x, Real exponent);

/// The power function of a StickLaw; identification has a faster one for many values.
template <typename Real>
struct Power {
  Real exponent;
  bool curves() const { return exponent != Real(1); }
  Real operator()(Real x) const { return power(x, exponent); }
};

/// Converts stick counts to a command in the unit of the axis. It has one function for each stage before delay and
/// dynamics; command() applies all of them:
///   v = moved(u)                                            u stick in counts from neutral
///   c = drifted(shaped(v) + leak of the other stick, t)     t = 0: no drift yet
///   a = limited(c)                                          after the tilt limit and before the slew limit
/// Cost: some 30 flops; where there is a stick curve one power, two with a tilt limit.
template <typename Real, typename Curve = Power<Real>>
class StickLaw {
 public:
  /// @param sample_period_s  of command(); for the slew of the command only
  StickLaw(const StickAxis& axis, Real sample_period_s)
      : scale_per_count_(real(axis.scale_per_count)),
        dead_zone_counts_(real(axis.dead_zone_counts)),
        jumps_(axis.dead_zone_shape == DeadZoneShape::kJump),
        trim_counts_(real(axis.trim_counts)),
        curve_{real(axis.stick_exponent)},
        positive_gain_(scale_per_count_ * Real(2) * real(axis.gain_asymmetry) / (Real(1) + real(axis.gain_asymmetry))),
        negative_gain_(scale_per_count_ * Real(2) / (Real(1) + real(axis.gain_asymmetry))),
        backlash_counts_(real(axis.backlash_counts)),
        drift_per_s_(real(axis.gain_drift_per_minute / 60.0)),
        leak_per_count_(scale_per_count_ * real(axis.cross_axis)),
        tilt_limit_(real(axis.tilt_limit)),
        other_scale_per_count_(axis.other_scale_per_count > 0.0 ? real(axis.other_scale_per_count) : scale_per_count_),
        saturation_(real(axis.saturation)),
        slew_per_sample_(real(axis.command_slew_per_s) * sample_period_s) {}

  /// Applies all stages; call it once per sample. The sticks are counts from neutral. @returns the sample's command
  Real command(Real stick_counts, Real other_counts, Real t_s) {
    return from_curved(curved(moved(stick_counts)), other_counts, t_s);
  }
  /// Whether gained() is the only stage after curved() that does anything.
  bool ends_with_gain() const {
    return drift_per_s_ == Real(0) && leak_per_count_ == Real(0) && !(tilt_limit_ > Real(0)) &&
           !(saturation_ > Real(0)) && !(slew_per_sample_ > Real(0));
  }
  Real gained(Real curved_counts) const {
    return curved_counts * (curved_counts < Real(0) ? negative_gain_ : positive_gain_);
  }
  /// Applies the stages after curved(). @returns the sample's command
  Real from_curved(Real curved_counts, Real other_counts, Real t_s) {
    Real command = drifted(gained(curved_counts) + leak_per_count_ * other_counts, t_s);
    if (tilt_limit_ > Real(0)) {
      const Real other = other_scale_per_count_ * dead_zone_and_curve(other_counts);
      const Real size = core::sqrt(command * command + other * other);
      if (size > tilt_limit_) {
        command *= tilt_limit_ / size;
      }
    }
    command = limited(command);
    if (slew_per_sample_ > Real(0)) {
      slewed_ = slewing_ ? slewed_ + core::clamp(command - slewed_, -slew_per_sample_, slew_per_sample_) : command;
      slewing_ = true;
      command = slewed_;
    }
    return command;
  }

  /// Resets the backlash as if the stick had always been at `stick_counts`.
  void rest_at(Real stick_counts) {
    play_counts_ = stick_counts;
    started_ = true;
  }
  /// The first stage, which has a memory: backlash.
  /// @returns the counts after it
  Real moved(Real stick_counts) {
    if (!started_) {
      rest_at(stick_counts);
    }
    if (backlash_counts_ > Real(0)) {
      play_counts_ = core::clamp(play_counts_, stick_counts - backlash_counts_, stick_counts + backlash_counts_);
      return play_counts_;
    }
    return stick_counts;
  }
  /// The stages without memory: trim, dead zone and stick curve. @returns counts
  Real curved(Real counts) const { return dead_zone_and_curve(counts - trim_counts_); }
  /// curved() and the gain. @returns the command without drift and leak
  Real shaped(Real counts) const { return gained(curved(counts)); }
  Real drifted(Real command, Real t_s) const { return command * (Real(1) + drift_per_s_ * t_s); }
  Real limited(Real command) const {
    return saturation_ > Real(0) ? core::clamp(command, -saturation_, saturation_) : command;
  }

 private:
  static Real real(double value) { return static_cast<Real>(value); }
  Real dead_zone_and_curve(Real counts) const {
    Real size = counts < Real(0) ? -counts : counts;
    if (dead_zone_counts_ > Real(0)) {
      if (size <= dead_zone_counts_) {
        return Real(0);
      }
      if (!jumps_) {
        size -= dead_zone_counts_;
      }
    }
    if (curve_.curves()) {
      constexpr Real kTravel = static_cast<Real>(paper::kTravel_vrc);
      if (!(size == curved_from_)) {  // a stick rests between two commands, and a power costs half of the law
        curved_from_ = size;
        curved_to_ = kTravel * curve_(size / kTravel);
      }
      size = curved_to_;
    }
    return counts < Real(0) ? -size : size;
  }

  Real scale_per_count_;
  Real dead_zone_counts_;
  bool jumps_;
  Real trim_counts_;
  Curve curve_;
  Real positive_gain_;
  Real negative_gain_;
  Real backlash_counts_;
  Real drift_per_s_;
  Real leak_per_count_;
  Real tilt_limit_;
  Real other_scale_per_count_;
  Real saturation_;
  Real slew_per_sample_;
  mutable Real curved_from_ = Real(-1);
  mutable Real curved_to_ = Real(0);
  Real play_counts_ = Real(0);
  Real slewed_ = Real(0);
  bool slewing_ = false;
  bool started_ = false;
};

/// What the response itself does behind delay and linear dynamics. Without an effect it changes nothing.
template <typename Real>
class ResponseLaw {
 public:
  explicit ResponseLaw(const StickAxis& axis) : limit_per_s_(static_cast<Real>(axis.rate_limit_per_s)) {}

  bool acts() const { return limit_per_s_ > Real(0); }
  /// @returns the rate y' of a second-order response.
  Real rate(Real rate_per_s) const {
    return limit_per_s_ > Real(0) ? core::clamp(rate_per_s, -limit_per_s_, limit_per_s_) : rate_per_s;
  }
  /// @returns the response step_s after it was `before`, where the linear dynamics give `after`.
  Real value(Real before, Real after, Real step_s) const {
    if (limit_per_s_ > Real(0)) {
      const Real most = limit_per_s_ * step_s;
      after = before + core::clamp(after - before, -most, most);
    }
    return after;
  }

 private:
  Real limit_per_s_;
};

}  // namespace m100::model
