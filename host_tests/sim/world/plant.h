// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "firmware/core/eigen.h"
#include "firmware/model/vehicle.h"

namespace m100::sim {

/// The air and its effect on the aircraft. Every translation effect that is an outer force and has a key in the vehicle
/// file acts on the velocity relative to the air.
struct Air : model::TranslationNumbers {
  /// From the paper's results table, the only measured number there is. The fan's 11..11.5 m/s raise the hover tilt RMS
  /// from 0.392 / 0.618 to 1.044 / 0.697 deg, that is by 0.968 / 0.322 deg (roots of differences of squares). The jet's
  /// turbulence accounts for 0.27 deg of it on each axis (in this simulation), which leaves 0.930 / 0.175 deg of steady
  /// tilt: g tan(0.946 deg) = 0.162 m/s^2 at 11.25 m/s. This is the drag of an aircraft partly inside a jet; the drag
  /// in a wide wind is more than ten times as large (published rotor drag: 0.2..0.5 1/s).
  static constexpr double kMeasuredDrag_per_s = 0.0144;
  Air() { linear_drag_per_s = kMeasuredDrag_per_s; }
  core::Vector<double, 3> wind_m_s = core::Vector<double, 3>::Zero();  ///< velocity of the air, world frame
  double gust_m_s = 0.0;  ///< amplitude of a sine along the mean wind (along x in calm air)
  double gust_hz = 0.2;
  double turbulence_m_s = 0.0;       ///< standard deviation per axis
  double turbulence_length_m = 2.0;  ///< correlation time is length over mean speed (at least 1 m/s)
  /// Lift near the ground, as a multiple of Cheeseman and Bennett's: 1 / (1 - (R / 4z)^2) for a rotor of radius R.
  double ground_effect = 0.0;
  // Motion that remains in still air while the sticks rest, measured on pitch_roll.csv and height.csv: coloured motion,
  // not sensor noise. Yaw is that of a held heading: it wanders and returns.
  double attitude_disturbance_rad = 0.004;
  double climb_disturbance_m_s = 0.05;
  double yaw_rate_disturbance_rad_s = 0.02;
  /// Turn rate of the air that the heading integrates, so that only a controller's yaw stick stops it. Standard
  /// deviation; it wanders in 0.25 s. In the world of the paper's flights it replaces yaw_rate_disturbance_rad_s.
  double turn_disturbance_rad_s = 0.0;
};

struct Payload {
  double mass_kg = 0.0;         ///< in addition to the vehicle's own
  double slung_length_m = 0.0;  ///< 0: bolted on; otherwise it hangs on a cord of this length
  double picked_up_at_s = 0.0;  ///< of the world's time
};

/// The phase of a pose source's captures relative to our ticks.
enum class PosePhase : std::uint8_t {
  kRandom,  ///< anywhere within its period, drawn from the seed
  kLocked,  ///< always at the same phase of our tick: easier than any real source
};

/// What a pose source reports about the age of its poses.
enum class ReportedAge : std::uint8_t {
  kTrue,      ///< it stamps its captures, and answers requests for its time
  kConstant,  ///< the same, but its poses seem reported_age_s old where latency_s is the truth: a constant error
  kNone,      ///< it stamps its captures, but does not answer requests for its time
};

/// The pose source, on a clock of its own.
struct PoseNumbers {
  double rate_hz = 100.0;
  double latency_s = 0.020;      ///< capture to arrival, the constant part
  double jitter_s = 0.0;         ///< added: uniform from 0 to this, drawn for each pose; poses may overtake each other
  double burst_s = 0.0;          ///< at times nothing arrives for this long, then all poses at once
  double burst_per_s = 0.0;      ///< how often
  double clock_drift_ppm = 0.0;  ///< of its clock against ours; positive: its clock runs fast
  PosePhase phase = PosePhase::kRandom;
  ReportedAge reported_age = ReportedAge::kTrue;
  double reported_age_s = 0.020;
  double sync_out_s = 0.0;   ///< delay of a request for its time, in addition to the line
  double sync_back_s = 0.0;  ///< delay of its answer
  double noise_m = 0.001;
  double noise_rad = 0.002;    ///< of the heading
  double quantum_m = 0.0;      ///< positions are multiples of it
  double dropout_per_s = 0.0;  ///< rate of dropouts: poses captured during a dropout never arrive
  double dropout_s = 0.1;      ///< duration of a dropout
};

struct Sensors {
  double attitude_noise_rad = 5e-5;
  double imu_rate_noise_rad_s = 0.003;
  double imu_acceleration_noise_m_s2 = 0.02;
  // Errors of the autopilot's own estimates, from pitch_roll.csv and height.csv (decision sim 5).
  double imu_offset_m_s2 = 0.2;       ///< of the specific force, drawn for each flight and axis
  double imu_vibration_m_s2 = 0.1;    ///< of the specific force, caused by the rotors; root mean square
  double velocity_zero_share = 0.45;  ///< share of time in which the horizontal velocity reads zero; 0: true velocity
  double height_drift_m = 0.3;        ///< of the barometer; it also jumps by about this much at times
};

struct Link {
  double baud = 921600.0;
  double clock_drift_ppm = 0.0;  ///< of the autopilot's clock against ours; positive: its clock runs fast
  double adapter_s = 0.001;  ///< received bytes are delivered in chunks, at multiples of this time (a latency timer)
  double command_delay_s = 0.010;  ///< from the autopilot's receiver to its attitude loop: one cycle of 100 Hz
  double drop = 0.0;               ///< share of bytes that are lost
  double bit_error_rate = 0.0;
};

struct Battery {
  double sag = 0.0;  ///< share of the motors' authority lost when it is empty, after 14 minutes (paper, IV-A)
  double start_percent = 100.0;
};

/// The emulated autopilot's own loops and filters, used where it flies a body of a physics program (--body json:...).
///
/// Chosen once, and not fitted to the identified response. The body: rotors 0.65 m apart across the diagonal, 13 inch
/// propellers, motors of 350 turns a minute and volt (as DJI publishes them), the paper's mass of 3.3 kg. Four motors
/// with their arms (0.19 kg each) and a box of 0.30 x 0.25 x 0.20 m have 0.062, 0.068, 0.112 kg m^2. Propeller and
/// motor (1.35e-4 kg m^2) braked by the motor's torque constant over 0.15 ohm and by the air follow in 25 ms. The rate
/// gain is then the magnitude optimum, 1 / (2 lag); outer gains, integrals and derivative are PX4's published defaults.
/// Phase margin with rotors of 25 ms: 58 degrees (38 without the derivative), 50 ms: 38, 65 ms: 30, 150 ms: none.
struct AutopilotNumbers {
  double rate_hz = 400.0;             ///< of the loops, and the frame rate that the physics program is asked for
  double attitude_gain_per_s = 6.5;   ///< MC_ROLL_P
  double rate_gain_per_s = 20.0;      ///< of roll and pitch
  double yaw_rate_gain_per_s = 10.0;  ///< half of it: yaw must not take the thrust that roll and pitch need
  double rate_integral_s = 0.75;      ///< MC_ROLLRATE_P / MC_ROLLRATE_I
  double rate_derivative_s = 0.02;    ///< MC_ROLLRATE_D / MC_ROLLRATE_P, roll and pitch only, as there
  double climb_gain_per_s = 4.0;      ///< MPC_Z_VEL_P_ACC
  double hover_learning_s = 2.0;      ///< MPC_Z_VEL_P_ACC / MPC_Z_VEL_I_ACC
  // Angular acceleration if two rotors have twice their hover thrust and two have none: m g arm / inertia; for yaw,
  // m g times the propellers' torque per thrust (0.02 m) over inertia.
  double roll_authority_rad_s2 = 120.0;
  double pitch_authority_rad_s2 = 109.0;
  double yaw_authority_rad_s2 = 5.8;
  double hover_thrust = 0.3;  ///< share of full thrust, before it is learned
  /// thrust = (1 - curve) u + curve u^2 of the throttle u; ArduPilot's default. A body whose thrust is linear or
  /// quadratic in u changes the loop gain by about 30 %.
  double thrust_curve = 0.65;
  /// Of the attitude to the accelerometer. Small, because the accelerometer of a quadrotor does not see its tilt in
  /// accelerated flight: each 0.01 1/s looks like 0.01 1/s less drag. The steady Kalman gain of a gyro that walks by
  /// 2e-4 rad/s^0.5 beside motion of 1 m/s^2 that lasts a second: 2e-4 / (0.1 sqrt(2 s)) = 0.0014.
  double accelerometer_gain_per_s = 0.0014;
  double barometer_s = 5.0;  ///< time constant of the climb filter; ArduPilot's default
};

struct Plant;

/// A change of the plant in flight.
struct Change {
  double at_s = 0.0;  ///< of the world's time
  std::vector<std::function<void(Plant&)>> steps{};
};

/// The true parameters of the simulated world. The controller and identification never see them.
struct Plant {
  model::StickAxis roll;
  model::StickAxis pitch;
  model::StickAxis yaw_rate;
  model::StickAxis climb;
  double mass_kg = 3.3;  ///< paper, IV-A
  Air air;
  Payload payload;
  PoseNumbers pose;
  Sensors sensors;
  Link link;
  Battery battery;
  AutopilotNumbers autopilot;
  Change change;
};

/// The plant after its change.
Plant changed(Plant plant);

/// The plant as measured. Roll, pitch: identified from pitch_roll.csv; climb: from height.csv; yaw rate: from yaw.csv;
/// trim: the paper, III-B.3. The source file states the origin of each number.
Plant measured_plant();

/// Adds the paper's fan (IV-C: 11..11.5 m/s at the hovering position; it stands in the south-east and pushes towards
/// +x and +y, IV-D.4), with the turbulence of a free jet and the heading disturbance the paper's yaw cells show.
Plant with_fan(Plant plant);

}  // namespace m100::sim
