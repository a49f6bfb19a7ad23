// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "firmware/app/flight_controller.h"
#include "protocol/mavlink/signature.h"
#include "protocol/mavlink/state_messages.h"

namespace m100::companion {

/// The state of a flight in one tick, for the ground station: a copy, so the sending thread needs nothing else.
struct FlightState {
  core::TimePoint now{};
  mavlink::SignatureTime signature_time = 0;  ///< least time stamp of the signatures of its messages
  std::array<double, 3> position_w_m{};
  std::array<double, 3> velocity_w_m_s{};
  core::Tilt<double> tilt;
  double yaw_rad = 0.0;
  std::array<float, 3> rate_frd_rad_s{};
  double horizontal_sigma_m = 0.0;  ///< of position, from the observer's covariance
  double gate_ratio = 0.0;          ///< of the newest pose if refused: its distance over the allowed one; else 0
  bool healthy = false;
  bool prediction_valid = false;
  bool in_control = false;
  safety::FailsafeState failsafe_state = safety::FailsafeState::kSilent;
  bool task_flies = false;  ///< the autopilot takes off or lands by itself
  bool has_battery = false;
  std::uint8_t battery_percent = 0;
};

FlightState state_of(const app::FlightController<double>& controller, core::TimePoint now);

// The state as MAVLink messages: NED and FRD, in the world of the pose.
mavlink::Heartbeat heartbeat_of(const FlightState& state);
mavlink::AttitudeQuaternion attitude_of(const FlightState& state);
mavlink::LocalPositionNed position_of(const FlightState& state);
mavlink::EstimatorStatus estimator_of(const FlightState& state);
mavlink::BatteryStatus battery_of(const FlightState& state);

/// Makes one piece of a sentence, 50 characters, as STATUSTEXT. @param id identifies a sentence of several pieces; not
/// 0. @param piece from 0. @returns false: there is no such piece.
bool status_text(std::string_view sentence, std::uint8_t severity, std::uint16_t id, std::uint8_t piece,
                 mavlink::StatusText& message);

/// MAV_SEVERITY of a line for the operator: a step of the failsafe is a warning.
std::uint8_t severity_of(std::string_view line);

}  // namespace m100::companion
