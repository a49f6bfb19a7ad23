// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "host_tests/lab/experiments/flight.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::loop {

/// Column map of our own flight logs: sticks, attitude, rates and velocity.
inline constexpr std::string_view kMotionColumns = R"(time = { column = "tick.timestamp", scale = 1.0 }
[signals]
stick_roll = { column = "tick.sticks[0]", offset = -1024 }
stick_pitch = { column = "tick.sticks[1]", offset = -1024 }
stick_throttle = { column = "tick.sticks[2]", offset = -1024 }
stick_yaw = { column = "tick.sticks[3]", offset = -1024 }
attitude_roll = "tick.imu_attitude[0]"
attitude_pitch = "tick.imu_attitude[1]"
attitude_yaw = "tick.imu_attitude[2]"
rate_x = "tick.imu_rate[0]"
rate_y = "tick.imu_rate[1]"
rate_z = "tick.imu_rate[2]"
velocity_x = "tick.velocity[0]"
velocity_y = "tick.velocity[1]"
velocity_z = "tick.velocity[2]"
)";

/// Column map of our own flight logs: what `m100-lab identify --columns` needs for them.
const std::string& own_columns();

/// The course of an identification flight: steps in x, y, height and heading of many sizes that the controller does not
/// know in advance, so that every stick is moved through its dead zone and its range. They stay within +-2 m in x and y
/// and +-0.8 m in height of the start. The same seed gives the same course.
std::string excitation(std::uint64_t seed, double duration_s);

/// Delays in our own log that the delay in a vehicle file (autopilot's stick to attitude) does not contain. They were
/// measured on simulated flights of a vehicle file as its own plant (--plant-from).
inline constexpr double kTelemetry_s = 0.0125;  ///< from the autopilot's attitude to the tick that logs it
inline constexpr double kUplink_s = 0.0055;     ///< from the tick that sets the sticks to the autopilot's receiver

struct FlownLog {
  logs::FlightLog log;
  identify::Range in_control;  ///< the longest time in which the logged sticks flew the vehicle [s, log's clock]
  std::string descent;         ///< why the failsafe ended that time, in words; "given_back": as planned
};

/// Writes the flight's ULog to a file, reads it back like any other log, and aligns it: sticks later by kUplink_s,
/// attitude and rates earlier by kTelemetry_s, position and the captured velocity earlier by the lag of the captured
/// heading (logs/alignment/capture_alignment.h). rate_z becomes the rate of the heading. Errors: InputError.
FlownLog load_flown(const experiments::FlightResult& flight, const std::string& path);

}  // namespace m100::lab::loop
