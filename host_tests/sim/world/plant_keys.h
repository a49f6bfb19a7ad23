// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "firmware/companion/files/vehicle_keys.h"
#include "host_tests/sim/world/plant.h"

// The keys of a plant file, section by section, without those of the axes, which are the vehicle file's.
namespace m100::sim {

using companion::NamedValue;
using companion::NumberKey;

inline constexpr std::array kOwnAirKeys{
    NumberKey<Air>{"ground_effect", &Air::ground_effect, 0.0, 20.0},
    NumberKey<Air>{"thrust_lag_s", &Air::thrust_lag_s, 0.0, 1.0},
    NumberKey<Air>{"gust_m_s", &Air::gust_m_s, 0.0, 20.0},
    NumberKey<Air>{"gust_hz", &Air::gust_hz, 0.0, 20.0},
    NumberKey<Air>{"turbulence_m_s", &Air::turbulence_m_s, 0.0, 20.0},
    NumberKey<Air>{"turbulence_length_m", &Air::turbulence_length_m, 0.05, 1000.0},
    NumberKey<Air>{"attitude_disturbance_rad", &Air::attitude_disturbance_rad, 0.0, 0.2},
    NumberKey<Air>{"climb_disturbance_m_s", &Air::climb_disturbance_m_s, 0.0, 2.0},
    NumberKey<Air>{"yaw_rate_disturbance_rad_s", &Air::yaw_rate_disturbance_rad_s, 0.0, 2.0},
    NumberKey<Air>{"turn_disturbance_rad_s", &Air::turn_disturbance_rad_s, 0.0, 2.0},
};
/// These keys, and the numbers of every translation effect that the simulated world can contain.
inline const std::vector<NumberKey<Air>>& air_keys() {
  static const std::vector<NumberKey<Air>> kKeys = [] {
    std::vector<NumberKey<Air>> keys(kOwnAirKeys.begin(), kOwnAirKeys.end());
    for (const auto& number : model::kEffectNumbers) {
      if (model::simulated(number.key)) {
        keys.push_back({number.key, number.member, number.low, number.high});
      }
    }
    return keys;
  }();
  return kKeys;
}
inline constexpr std::array kPayloadKeys{
    NumberKey<Payload>{"mass_kg", &Payload::mass_kg, 0.0, 10.0},
    NumberKey<Payload>{"picked_up_at_s", &Payload::picked_up_at_s, 0.0, 1e6},
    NumberKey<Payload>{"slung_length_m", &Payload::slung_length_m, 0.0, 50.0},
};
inline constexpr std::array kPoseKeys{
    NumberKey<PoseNumbers>{"rate_hz", &PoseNumbers::rate_hz, 5.0, 500.0},
    NumberKey<PoseNumbers>{"latency_s", &PoseNumbers::latency_s, 0.0, 1.0},
    NumberKey<PoseNumbers>{"jitter_s", &PoseNumbers::jitter_s, 0.0, 1.0},
    NumberKey<PoseNumbers>{"burst_s", &PoseNumbers::burst_s, 0.0, 10.0},
    NumberKey<PoseNumbers>{"burst_per_s", &PoseNumbers::burst_per_s, 0.0, 100.0},
    NumberKey<PoseNumbers>{"clock_drift_ppm", &PoseNumbers::clock_drift_ppm, -10000.0, 10000.0},
    NumberKey<PoseNumbers>{"reported_age_s", &PoseNumbers::reported_age_s, 0.0, 9.0},
    NumberKey<PoseNumbers>{"sync_out_s", &PoseNumbers::sync_out_s, 0.0, 1.0},
    NumberKey<PoseNumbers>{"sync_back_s", &PoseNumbers::sync_back_s, 0.0, 1.0},
    NumberKey<PoseNumbers>{"noise_m", &PoseNumbers::noise_m, 0.0, 1.0},
    NumberKey<PoseNumbers>{"noise_rad", &PoseNumbers::noise_rad, 0.0, 0.5},
    NumberKey<PoseNumbers>{"quantum_m", &PoseNumbers::quantum_m, 0.0, 1.0},
    NumberKey<PoseNumbers>{"dropout_per_s", &PoseNumbers::dropout_per_s, 0.0, 100.0},
    NumberKey<PoseNumbers>{"dropout_s", &PoseNumbers::dropout_s, 0.0, 10.0},
};
/// Keys that older files have in [sensors], and their present names in [pose].
struct KeyAlias {
  std::string_view old;
  std::string_view key;
};
inline constexpr std::array kPoseKeyAliases{
    KeyAlias{"pose_noise_m", "noise_m"}, KeyAlias{"pose_yaw_noise_rad", "noise_rad"},
    KeyAlias{"pose_delay_s", "latency_s"}, KeyAlias{"pose_dropout_per_s", "dropout_per_s"},
    KeyAlias{"pose_dropout_s", "dropout_s"}};
inline constexpr std::array kPhases{NamedValue<PosePhase>{"random", PosePhase::kRandom},
                                    NamedValue<PosePhase>{"locked", PosePhase::kLocked}};
inline constexpr std::array kReportedAges{NamedValue<ReportedAge>{"true", ReportedAge::kTrue},
                                          NamedValue<ReportedAge>{"constant", ReportedAge::kConstant},
                                          NamedValue<ReportedAge>{"none", ReportedAge::kNone}};
inline constexpr std::array kSensorKeys{
    NumberKey<Sensors>{"attitude_noise_rad", &Sensors::attitude_noise_rad, 0.0, 0.5},
    NumberKey<Sensors>{"imu_offset_m_s2", &Sensors::imu_offset_m_s2, 0.0, 10.0},
    NumberKey<Sensors>{"imu_vibration_m_s2", &Sensors::imu_vibration_m_s2, 0.0, 50.0},
    NumberKey<Sensors>{"velocity_zero_share", &Sensors::velocity_zero_share, 0.0, 1.0},
    NumberKey<Sensors>{"height_drift_m", &Sensors::height_drift_m, 0.0, 10.0},
    NumberKey<Sensors>{"imu_rate_noise_rad_s", &Sensors::imu_rate_noise_rad_s, 0.0, 1.0},
    NumberKey<Sensors>{"imu_acceleration_noise_m_s2", &Sensors::imu_acceleration_noise_m_s2, 0.0, 10.0},
};
inline constexpr std::array kLinkKeys{
    NumberKey<Link>{"baud", &Link::baud, 9600.0, 4e6},
    NumberKey<Link>{"clock_drift_ppm", &Link::clock_drift_ppm, -10000.0, 10000.0},
    NumberKey<Link>{"adapter_s", &Link::adapter_s, 0.0, 0.1},
    NumberKey<Link>{"command_delay_s", &Link::command_delay_s, 0.0, 0.5},
    NumberKey<Link>{"drop", &Link::drop, 0.0, 1.0},
    NumberKey<Link>{"bit_error_rate", &Link::bit_error_rate, 0.0, 0.1},
};
inline constexpr std::array kBatteryKeys{NumberKey<Battery>{"sag", &Battery::sag, 0.0, 0.9},
                                         NumberKey<Battery>{"start_percent", &Battery::start_percent, 0.0, 100.0}};
using Autopilot = AutopilotNumbers;
inline constexpr std::array kAutopilotKeys{
    NumberKey<Autopilot>{"rate_hz", &Autopilot::rate_hz, 101.0, 2000.0},
    NumberKey<Autopilot>{"attitude_gain_per_s", &Autopilot::attitude_gain_per_s, 0.5, 30.0},
    NumberKey<Autopilot>{"rate_gain_per_s", &Autopilot::rate_gain_per_s, 0.5, 100.0},
    NumberKey<Autopilot>{"yaw_rate_gain_per_s", &Autopilot::yaw_rate_gain_per_s, 0.1, 100.0},
    NumberKey<Autopilot>{"rate_integral_s", &Autopilot::rate_integral_s, 0.05, 1e6},
    NumberKey<Autopilot>{"rate_derivative_s", &Autopilot::rate_derivative_s, 0.0, 0.2},
    NumberKey<Autopilot>{"climb_gain_per_s", &Autopilot::climb_gain_per_s, 0.1, 20.0},
    NumberKey<Autopilot>{"hover_learning_s", &Autopilot::hover_learning_s, 0.2, 100.0},
    NumberKey<Autopilot>{"roll_authority_rad_s2", &Autopilot::roll_authority_rad_s2, 1.0, 10000.0},
    NumberKey<Autopilot>{"pitch_authority_rad_s2", &Autopilot::pitch_authority_rad_s2, 1.0, 10000.0},
    NumberKey<Autopilot>{"yaw_authority_rad_s2", &Autopilot::yaw_authority_rad_s2, 0.1, 10000.0},
    NumberKey<Autopilot>{"hover_thrust", &Autopilot::hover_thrust, 0.05, 0.9},
    NumberKey<Autopilot>{"thrust_curve", &Autopilot::thrust_curve, 0.0, 1.0},
    NumberKey<Autopilot>{"accelerometer_gain_per_s", &Autopilot::accelerometer_gain_per_s, 0.0, 10.0},
    NumberKey<Autopilot>{"barometer_s", &Autopilot::barometer_s, 0.2, 100.0},
};
inline constexpr std::array kVehicleKeys{NumberKey<Plant>{"mass_kg", &Plant::mass_kg, 0.5, 20.0}};

}  // namespace m100::sim
