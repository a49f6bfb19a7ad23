// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/app/tick_record.h"
#include "protocol/mavlink/state_messages.h"

namespace m100::companion {

// The tick as MAVLink messages: NED and FRD, in the world of the pose.
mavlink::Heartbeat heartbeat_of(const app::TickRecord<double>& record);
mavlink::AttitudeQuaternion attitude_of(const app::TickRecord<double>& record);
mavlink::LocalPositionNed position_of(const app::TickRecord<double>& record);
mavlink::EstimatorStatus estimator_of(const app::TickRecord<double>& record);
mavlink::BatteryStatus battery_of(const app::TickRecord<double>& record);

/// Makes one piece of a sentence, 50 characters, as STATUSTEXT. @param id identifies a sentence of several pieces; not
/// 0. @param piece from 0. @returns false: there is no such piece.
bool status_text(std::string_view sentence, std::uint8_t severity, std::uint16_t id, std::uint8_t piece,
                 mavlink::StatusText& message);

/// MAV_SEVERITY of a line for the operator: a step of the failsafe is a warning.
std::uint8_t severity_of(std::string_view line);

}  // namespace m100::companion
