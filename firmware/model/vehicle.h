// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/stick_axis.h"
#include "firmware/model/translation.h"

namespace m100::model {

/// Weights of the horizontal MPC (paper, Eq. 2), SI units: cost per m^2, (m/s)^2, rad^2. The defaults are those of a
/// vehicle file. `m100-lab gains --tune` chooses the input weight of its [design].
struct MpcWeights {
  double position = 40.0;
  double velocity = 20.0;
  double tilt = 20.0;
  double input = 1.5;
  double input_rate = 0.3;
};

/// Noise that the disturbance EKF assumes: process noise as sigma per sqrt(s), measurement noise as sigma.
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
  /// true: the three gains follow from the climb dynamics (ctl::design_altitude); false: those below are used.
  bool design = true;
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

/// What the controller predicts and estimates with, where that differs from what was identified ([design.*] of the
/// vehicle file, made by `m100-lab gains --tune`). An axis that is not identified here, and weights and noises that the
/// file does not have here, are those of the vehicle itself.
struct Design {
  StickAxis roll;
  StickAxis pitch;
  MpcWeights mpc;
  EstimatorNoise estimator;
  bool has_mpc = false;
  bool has_estimator = false;

  constexpr bool exists() const { return has_mpc || has_estimator || roll.is_identified() || pitch.is_identified(); }
};

/// The controller's model of the aircraft: the numbers of the vehicle file. Host and target share it; on the target it
/// is a constexpr object that `m100-lab gains` writes beside the tables.
struct Vehicle {
  StickAxis roll{.scale_per_count = 8.65e-4};
  StickAxis pitch{.scale_per_count = 8.65e-4};
  StickAxis yaw_rate;
  StickAxis climb;
  Translation translation;
  MpcWeights mpc;
  EstimatorNoise estimator;
  AltitudeGains altitude;
  YawGain yaw;
  Design design{};  ///< of mode field
  Design robust{};  ///< of mode robust
};

/// The axes, noise and weights that fly: those of the design where it has them, otherwise those of the vehicle.
constexpr const StickAxis& flown_roll(const Vehicle& vehicle) {
  return vehicle.design.roll.is_identified() ? vehicle.design.roll : vehicle.roll;
}
constexpr const StickAxis& flown_pitch(const Vehicle& vehicle) {
  return vehicle.design.pitch.is_identified() ? vehicle.design.pitch : vehicle.pitch;
}
constexpr const EstimatorNoise& flown_noise(const Vehicle& vehicle) {
  return vehicle.design.has_estimator ? vehicle.design.estimator : vehicle.estimator;
}
constexpr const MpcWeights& flown_weights(const Vehicle& vehicle) {
  return vehicle.design.has_mpc ? vehicle.design.mpc : vehicle.mpc;
}
constexpr MpcWeights& flown_weights(Vehicle& vehicle) {
  return vehicle.design.has_mpc ? vehicle.design.mpc : vehicle.mpc;
}

/// The vehicle as law, prediction and observer take it: identified numbers, replaced by those of `design`. Stick map,
/// monitors and reports keep the identified axes. The result has no design: a second call changes nothing.
constexpr Vehicle controller_model(const Vehicle& vehicle) {
  Vehicle out = vehicle;
  out.roll = flown_roll(vehicle);
  out.pitch = flown_pitch(vehicle);
  out.mpc = flown_weights(vehicle);
  out.estimator = flown_noise(vehicle);
  out.design = out.robust = {};
  return out;
}

/// Standard gravity, rounded as in the benchmark and the paper's own code.
inline constexpr double kGravity_m_s2 = 9.8066;

}  // namespace m100::model
