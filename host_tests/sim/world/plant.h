// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "firmware/core/eigen.h"
#include "firmware/model/vehicle.h"

namespace m100::sim {

/// The air and what it does to the aircraft: every translation effect that the vehicle file has a key for and that is
/// an outer force acts on the velocity relative to the air.
struct Air : model::TranslationNumbers {
  /// From the paper's results table, the only measured number there is. The fan's 11..11.5 m/s raise the hover tilt RMS
  /// from 0.392 / 0.618 to 1.044 / 0.697 deg, that is by 0.968 / 0.322 deg (roots of differences of squares). The jet's
  /// turbulence accounts for 0.27 deg of it on each axis (in this simulation), which leaves 0.930 / 0.175 deg of steady
  /// tilt: g tan(0.946 deg) = 0.162 m/s^2 at 11.25 m/s. It is the drag of an aircraft partly inside a jet; a wide wind
  /// pulls some ten times as hard (published rotor drag: 0.2..0.5 1/s), see the README.
  static constexpr double kMeasuredDrag_per_s = 0.0144;
  Air() { linear_drag_per_s = kMeasuredDrag_per_s; }
  core::Vector<double, 3> wind_m_s = core::Vector<double, 3>::Zero();  ///< world, where the air goes to
  double gust_m_s = 0.0;  ///< amplitude of a sine along the mean wind (along x in calm air)
  double gust_hz = 0.2;
  double turbulence_m_s = 0.0;       ///< standard deviation per axis
  double turbulence_length_m = 2.0;  ///< correlation time is length over mean speed (at least 1 m/s)
  /// Lift near the ground, as a multiple of Cheeseman and Bennett's: 1 / (1 - (R / 4z)^2) for a rotor of radius R.
  double ground_effect = 0.0;
  // What still air and the autopilot leave while the sticks rest, measured on pitch_roll.csv and height.csv: coloured
  // motion, not sensor noise. Yaw is that of a held heading: it wanders and comes back.
  double attitude_disturbance_rad = 0.004;
  double climb_disturbance_m_s = 0.05;
  double yaw_rate_disturbance_rad_s = 0.02;
};

struct Payload {
  double mass_kg = 0.0;         ///< beyond the vehicle's own
  double slung_length_m = 0.0;  ///< 0: bolted on; else it hangs on a cord of this length
  double picked_up_at_s = 0.0;  ///< of the world's time
};

/// How the captures of a source of pose lie in time against our ticks.
enum class PosePhase : std::uint8_t {
  kRandom,  ///< anywhere within its period, drawn from the seed
  kLocked,  ///< always at the same place of our tick: kinder than any real source
};

/// What a source of pose says about the age of what it sends.
enum class ReportedAge : std::uint8_t {
  kTrue,      ///< it stamps its captures, and answers when it is asked for its time
  kConstant,  ///< the same, but it believes a pose to be reported_age_s old where latency_s is the truth: off by a
              ///< constant
  kNone,      ///< it stamps its captures by a clock that it tells nobody
};

/// The source of pose, on a clock of its own.
struct PoseNumbers {
  double rate_hz = 100.0;
  double latency_s = 0.020;      ///< capture to arrival, the part that is always there
  double jitter_s = 0.0;         ///< on top, uniform from 0 to this, drawn for each pose: poses may overtake each other
  double burst_s = 0.0;          ///< now and then nothing arrives for so long, then all at once
  double burst_per_s = 0.0;      ///< how often
  double clock_drift_ppm = 0.0;  ///< of its clock against ours; positive: its clock runs fast
  PosePhase phase = PosePhase::kRandom;
  ReportedAge reported_age = ReportedAge::kTrue;
  double reported_age_s = 0.020;
  double sync_out_s = 0.0;   ///< what a question for its time takes to reach it, beyond the line
  double sync_back_s = 0.0;  ///< and its answer to come back
  double noise_m = 0.001;
  double noise_rad = 0.002;    ///< of the heading
  double quantum_m = 0.0;      ///< positions are multiples of it
  double dropout_per_s = 0.0;  ///< how often the pose stops coming: what is captured then never arrives
  double dropout_s = 0.1;      ///< for how long
};

struct Sensors {
  double attitude_noise_rad = 5e-5;
  double imu_rate_noise_rad_s = 0.003;
  double imu_acceleration_noise_m_s2 = 0.02;
  // What the autopilot's own estimates are like, from pitch_roll.csv and height.csv (figures in sim/README.md).
  double imu_offset_m_s2 = 0.2;       ///< of the specific force, drawn for each flight and axis
  double imu_vibration_m_s2 = 0.1;    ///< of the specific force, by the rotors; root mean square
  double velocity_zero_share = 0.45;  ///< of the time in which the horizontal velocity reads zero; 0: it is the truth
  double height_drift_m = 0.3;        ///< of the barometer; it also jumps by as much now and then
};

struct Link {
  double baud = 921600.0;
  double clock_drift_ppm = 0.0;  ///< of the autopilot's clock against ours; positive: its clock runs fast
  double adapter_s = 0.001;  ///< bytes are handed over in chunks, what has come by multiples of this (a latency timer)
  double command_delay_s = 0.010;  ///< from the autopilot's receiver to its attitude loop: one cycle of 100 Hz
  double drop = 0.0;               ///< share of bytes that vanish
  double bit_error_rate = 0.0;
};

struct Battery {
  double sag = 0.0;  ///< share of the motors' authority lost when it is empty, after 14 minutes (paper, IV-A)
  double start_percent = 100.0;
};

struct Plant;

/// What becomes of a plant in mid-flight.
struct Change {
  double at_s = 0.0;  ///< of the world's time
  std::vector<std::function<void(Plant&)>> steps{};
};

/// What the simulated world really is. Never shown to the controller or to identification.
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
  Change change;
};

/// The plant after its change.
Plant changed(Plant plant);

/// The plant as measured. Roll, pitch: identified from pitch_roll.csv; climb: from height.csv; yaw rate: the paper's
/// fit (Table I, III-D.3, III-B.5); trim: III-B.3. Which number comes from where stands in the source.
Plant measured_plant();

/// Adds the paper's fan (IV-C: 11..11.5 m/s at the hovering position; it stands in the south-east and pushes towards
/// +x and +y, IV-D.4), with the turbulence of a free jet and the heading disturbance the paper's yaw cells show.
Plant with_fan(Plant plant);

}  // namespace m100::sim
