// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace m100::oracle {

/// Parameters of one axis. The unit of the response is rad (roll, pitch), rad/s (yaw) or m/s (climb).
struct AxisParameters {
  double gain = 9e-4;  ///< per count
  double frequency_rad_s = 8.0;
  double damping = 0.7;
  bool first_order = false;  ///< of time constant 1 / frequency_rad_s
  double lag_s = 0.0;        ///< of motors and rotors, first order, in addition to the second order
  double delay_s = 0.0;      ///< at most kMaxDelay_s
  double dead_zone_counts = 0.0;
  double jump_counts = 0.0;  ///< a dead zone without which the stick acts in full
  double trim_counts = 0.0;
  double backlash_counts = 0.0;  ///< half width
  double asymmetry = 1.0;        ///< gain to the right over gain to the left; their mean is `gain`
  double exponent = 1.0;         ///< of the stick's curve over 660 counts
  double saturation = 1e9;       ///< of the command, unit of the response
  double tilt_limit = 1e9;       ///< of the command together with that of the other stick, for the same gain
  double rate_limit_per_s = 1e9;
  double drift_per_minute = 0.0;
  double cross = 0.0;         ///< gain of the other stick
  double product = 0.0;       ///< gain of the product of both sticks over 660 counts
  double lead_s = 0.0;        ///< zero of the command, after a filter of 5 ms
  double spring_per_s = 0.0;  ///< of a tether: pulls the response back in proportion to the distance beyond tether_m
  double tether_m = 0.0;
};

/// Gives a vehicle the effect with this name of the contract's table; "gain" and "frequency" are factors.
/// @returns whether the vehicle has such an effect.
bool set_effect(AxisParameters& parameters, std::string_view name, double value);

/// The one vehicle that judges the identification, and shares no code with it or with the simulator: the response of
/// one axis to its stick, by Heun's method, without air and noise.
class AxisVehicle {
 public:
  static constexpr double kMaxDelay_s = 1.0;

  AxisVehicle(const AxisParameters& parameters, double step_s);
  /// Changes the vehicle; its state stays.
  void set_parameters(const AxisParameters& parameters) { parameters_ = parameters; }
  /// Advances by one step with these sticks [counts from neutral]. @returns the response before the step.
  double step(double own, double other) { return respond(command(own, other)); }
  /// The two halves of step(): the command that the sticks give, and the response to it.
  double command(double own, double other);
  double respond(double command);
  double response() const { return response_; }
  double rate() const { return rate_; }
  void stop() { response_ = rate_ = filtered_ = lagged_ = 0.0; }

 private:
  double arrived(const std::vector<double>& sent) const;

  AxisParameters parameters_;
  double step_s_;
  std::vector<double> own_, other_;  ///< the sticks of the last kMaxDelay_s, in a ring
  std::size_t count_ = 0;            ///< of sticks so far
  double play_ = 0.0;
  double filtered_ = 0.0;
  double lagged_ = 0.0;
  double response_ = 0.0;
  double rate_ = 0.0;
  double flown_m_ = 0.0;
};

}  // namespace m100::oracle
