// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "firmware/model/vehicle.h"

namespace m100::sim {

/// What an attitude axis and a rate axis have in common, as the simulation integrates it.
struct AxisLaw {
  double scale_per_count = 0.0;
  double time_constant_s = 0.0;  ///< > 0: first order
  double natural_frequency_rad_s = 0.0;
  double damping_ratio = 0.0;
  double transport_delay_s = 0.0;
  double lead_zero_s = 0.0;
  double dead_zone_counts = 0.0;
  model::DeadZoneShape dead_zone_shape = model::DeadZoneShape::kContinuous;
  double trim_counts = 0.0;
  double saturation = 0.0;
  double rate_limit = 0.0;
  double gain_asymmetry = 1.0;
  double stick_exponent = 1.0;
  double backlash_counts = 0.0;
  double gain_drift_per_minute = 0.0;
};
AxisLaw law_of(const model::AttitudeAxis& axis);
AxisLaw law_of(const model::RateAxis& axis);

/// One axis of the autopilot, from stick counts to angle (or rate, or climb speed), see model::AttitudeAxis for the
/// equations. Order: backlash, trim, delay | dead zone, curve, asymmetry, scale with drift, cross axis, saturation |
/// lead zero, dynamics, rate limit.
class StickAxis {
 public:
  /// @param extra_delay_s of the command path, on top of the axis' own delay.
  explicit StickAxis(const AxisLaw& law, double extra_delay_s = 0.0);

  /// A stick in counts of the Virtual RC (centre 1024), in force from now on.
  void set_stick(double counts);
  /// A command in the axis' own unit, past the stick's law (movement control): delay and dynamics still apply.
  void set_direct(double command);

  /// The static law's answer to the input as it was a delay ago, before saturation: what crosses over to other axes.
  double commanded() const;
  /// Integrates one step (at most 10 ms; midpoint rule) towards commanded() + added.
  /// @param authority factor on bandwidth, 1 for a fresh battery and no payload.
  void advance(double step_s, double added, double authority = 1.0);

  double output() const { return output_; }
  double output_rate() const { return output_rate_; }
  const AxisLaw& law() const { return law_; }

 private:
  struct Input {
    double since_s = 0.0;
    double value = 0.0;
    bool direct = false;
  };
  const Input& delayed() const;
  void remember(double value, bool direct);
  double static_law(double counts) const;

  static constexpr std::size_t kPast = 512;  ///< input changes kept, for delays far beyond any measured one
  AxisLaw law_;
  double delay_s_;
  std::array<Input, kPast> past_{};
  std::size_t newest_ = 0;
  mutable std::size_t in_force_ = 0;  ///< index into past_ of the delayed input; only ever moves forward
  double backlash_ = 0.0;
  double time_s_ = 0.0;
  double state_ = 0.0;
  double state_rate_ = 0.0;
  double output_ = 0.0;
  double output_rate_ = 0.0;
};

}  // namespace m100::sim
