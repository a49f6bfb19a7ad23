// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace m100::model {

/// How a dead zone passes what is outside of it.
enum class DeadZoneShape : std::uint8_t {
  kContinuous,  ///< counted from the edge: f(u) = sign(u) (|u| - w) for |u| > w
  kJump,        ///< f(u) = u for |u| > w
};

/// One attitude axis as the autopilot answers to its stick. Static law: angle = scale * f(counts - trim), f the dead
/// zone and curve; then delay, lead zero and dynamics:
///   second order: phi'' = w^2 (a - phi) - 2 z w phi', a the static law of the stick transport_delay_s ago
///                 (+ lead_zero_s * a' where it is not zero)
///   first order : phi' = (a - phi) / time_constant_s
/// An axis is of first order if and only if time_constant_s > 0. Zero means "no such effect" everywhere else.
struct AttitudeAxis {
  double scale_rad_per_count = 8.65e-4;
  double time_constant_s = 0.0;
  double natural_frequency_rad_s = 0.0;
  double damping_ratio = 0.0;
  double transport_delay_s = 0.0;
  double lead_zero_s = 0.0;
  double dead_zone_counts = 0.0;  ///< half width
  DeadZoneShape dead_zone_shape = DeadZoneShape::kContinuous;
  double trim_counts = 0.0;  ///< balancing point minus 1024; taken from the stick before the dead zone
  // Effects that identification may add.
  double saturation_rad = 0.0;    ///< |a| limit; 0: none
  double rate_limit_rad_s = 0.0;  ///< |phi'| limit; 0: none
  double gain_asymmetry = 1.0;    ///< gain for positive over gain for negative sticks
  double stick_exponent = 1.0;    ///< f(u) = sign(u) 660 (|u| / 660)^exponent
  double backlash_counts = 0.0;   ///< half width
  double gain_drift_per_minute = 0.0;
  double cross_axis = 0.0;  ///< share of the other axis' command that arrives here
  constexpr bool is_first_order() const { return time_constant_s > 0.0; }
};

/// Yaw rate [rad/s] or climb speed [m/s] as answered to its stick; same law as an attitude axis.
struct RateAxis {
  double scale_per_count = 0.0;  ///< rad/s or m/s per count
  double time_constant_s = 0.0;
  double natural_frequency_rad_s = 0.0;
  double damping_ratio = 0.0;
  double transport_delay_s = 0.0;
  double dead_zone_counts = 0.0;
  DeadZoneShape dead_zone_shape = DeadZoneShape::kContinuous;
  double trim_counts = 0.0;
  double stick_exponent = 1.0;
  double limit = 0.0;       ///< |output| limit in rad/s or m/s; 0: none
  double rate_limit = 0.0;  ///< slew of the output per second; 0: none
  double gain_asymmetry = 1.0;
  // Effects that identification may add; files say them only where they are there.
  double lead_zero_s = 0.0;
  double backlash_counts = 0.0;  ///< half width
  double gain_drift_per_minute = 0.0;
};

/// Horizontal motion: v' = tilt_gain g tan(tilt) - linear_drag v - quadratic_drag |v| v + wind, about hover.
struct Translation {
  double mass_kg = 3.3;  ///< paper, IV-A
  double linear_drag_per_s = 0.01;
  double quadratic_drag_per_m = 0.0;
  double tilt_limit_rad = 0.43633231299858238;  ///< 25 deg
  double tilt_gain = 1.0;
  double thrust_gain = 1.0;
  double thrust_lag_s = 0.0;
};

/// Weights of the horizontal MPC (paper, Eq. 2), SI units: cost per m^2, (m/s)^2, rad^2. The paper's code has input 35:
/// as much robustness as its delay-blind model could get. With the delay predicted, 1.5 keeps a peak sensitivity of 1.4
/// and a delay margin above 100 ms on the identified axes (`m100-lab gains` prints them, `--tune` chooses).
struct MpcWeights {
  double position = 40.0;
  double velocity = 20.0;
  double tilt = 20.0;
  double input = 1.5;
  double input_rate = 0.3;
};

/// Noise the disturbance EKF assumes. Process noise as power density per second, measurement noise as sigma.
struct EstimatorNoise {
  double position_process_m = 1e-4;         ///< per sqrt(s)
  double velocity_process_m_s = 0.001;      ///< per sqrt(s)
  double tilt_process_rad = 1e-3;           ///< per sqrt(s)
  double tilt_rate_process_rad_s = 0.3;     ///< per sqrt(s)
  double disturbance_process_m_s2 = 0.15;   ///< per sqrt(s)
  double input_offset_process_rad = 0.001;  ///< per sqrt(s)
  double pose_position_sigma_m = 0.002;
  double pose_velocity_sigma_m_s = 0.02;
  double attitude_sigma_rad = 0.005;
  double rate_sigma_rad_s = 0.02;
};

/// Height PID (paper, III-E.2). The integral is limited to [integral_min, integral_max] m/s.
struct AltitudeGains {
  double proportional_per_s = 1.963;
  double integral_per_s2 = 6.190;
  double derivative = 0.156;
  double integral_min_m_s = -0.2;
  double integral_max_m_s = 0.2;
  double climb_limit_m_s = 2.0;
};

struct YawGain {
  double proportional_per_s = 1.5;
  double rate_limit_rad_s = 1.0;
};

/// What the controller believes about the aircraft: the vehicle file as numbers. Host and target share it; the target
/// gets it as a constexpr object that `m100-lab gains` writes beside the tables.
struct Vehicle {
  AttitudeAxis roll;
  AttitudeAxis pitch;
  RateAxis yaw_rate;
  RateAxis climb;
  Translation translation;
  MpcWeights mpc;
  EstimatorNoise estimator;
  AltitudeGains altitude;
  YawGain yaw;
};

/// Standard gravity as the benchmark and the paper's own code round it.
inline constexpr double kGravity_m_s2 = 9.8066;

}  // namespace m100::model
