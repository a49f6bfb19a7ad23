// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/core/eigen.h"
#include "firmware/model/vehicle.h"

namespace m100::sim {

/// The air and what it does to the aircraft. Drag acts on the velocity relative to the air:
///   v' = ... - linear_drag (v - w) - quadratic_drag |v - w| (v - w)
struct Air {
  /// From the paper's results table, the only measured number there is. The fan's 11..11.5 m/s raise the hover tilt RMS
  /// from 0.392 / 0.618 to 1.044 / 0.697 deg, that is by 0.968 / 0.322 deg (roots of differences of squares). The jet's
  /// turbulence accounts for 0.27 deg of it on each axis (in this simulation), which leaves 0.930 / 0.175 deg of steady
  /// tilt: g tan(0.946 deg) = 0.162 m/s^2 at 11.25 m/s. It is the drag of an aircraft partly inside a jet; a wide wind
  /// pulls some ten times as hard (published rotor drag: 0.2..0.5 1/s), see the README.
  double linear_drag_per_s = 0.0144;
  double quadratic_drag_per_m = 0.0;
  core::Vector<double, 3> wind_m_s = core::Vector<double, 3>::Zero();  ///< world, where the air goes to
  double gust_m_s = 0.0;  ///< amplitude of a sine along the mean wind (along x in calm air)
  double gust_hz = 0.2;
  double turbulence_m_s = 0.0;       ///< standard deviation per axis
  double turbulence_length_m = 2.0;  ///< correlation time is length over mean speed (at least 1 m/s)
  // What still air and the autopilot leave while the sticks rest, measured on pitch_roll.csv and height.csv: coloured
  // motion, not sensor noise. Yaw is that of a held heading: it wanders and comes back.
  double attitude_disturbance_rad = 0.004;
  double climb_disturbance_m_s = 0.05;
  double yaw_rate_disturbance_rad_s = 0.02;
};

struct Payload {
  double mass_kg = 0.0;         ///< beyond the vehicle's own
  double slung_length_m = 0.0;  ///< 0: bolted on; else it hangs on a cord of this length
};

struct Sensors {
  double pose_noise_m = 0.001;
  double pose_yaw_noise_rad = 0.002;
  double pose_delay_s = 0.020;
  double pose_dropout_per_s = 0.0;  ///< how often the pose stops coming
  double pose_dropout_s = 0.1;      ///< for how long
  double attitude_noise_rad = 5e-5;
  double imu_rate_noise_rad_s = 0.003;
  double imu_acceleration_noise_m_s2 = 0.02;
};

struct Link {
  double baud = 921600.0;
  double command_delay_s = 0.010;  ///< from the autopilot's receiver to its attitude loop: one cycle of 100 Hz
  double drop = 0.0;               ///< share of bytes that vanish
  double bit_error_rate = 0.0;
};

struct Battery {
  double sag = 0.0;  ///< share of the motors' authority lost when it is empty, after 14 minutes (paper, IV-A)
};

/// What the simulated world really is. Never shown to the controller or to identification.
struct Plant {
  model::AttitudeAxis roll;
  model::AttitudeAxis pitch;
  model::RateAxis yaw_rate;
  model::RateAxis climb;
  double mass_kg = 3.3;  ///< paper, IV-A
  Air air;
  Payload payload;
  Sensors sensors;
  Link link;
  Battery battery;
};

/// The plant as measured. Roll, pitch: identified from pitch_roll.csv; climb: from height.csv; yaw rate: the paper's
/// fit (Table I, III-D.3, III-B.5); trim: III-B.3. Which number comes from where stands in the source.
Plant measured_plant();

/// Adds the paper's fan (IV-C: 11..11.5 m/s at the hovering position; it stands in the south-east and pushes towards
/// +x and +y, IV-D.4), with the turbulence of a free jet and the heading disturbance the paper's yaw cells show.
Plant with_fan(Plant plant);

}  // namespace m100::sim
