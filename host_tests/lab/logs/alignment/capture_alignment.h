// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::logs {

// Aligns motion capture with the autopilot's measurements.

/// Delay [s] of the captured heading after the autopilot's heading, by least squares over the range. Both measure the
/// same angle, so no model of the vehicle is needed. Differences over 0.5 s are compared, so that a drift of the
/// autopilot's heading does not matter.
/// @param captured_heading_rad  one value for each sample of the log
/// @param otherwise_s           result where a heading is missing or hardly turned, or the lag would exceed 0.2 s
double capture_lag_s(const FlightLog& log, std::vector<double> captured_heading_rad, std::pair<double, double> range_s,
                     double otherwise_s);

/// The log with the position shifted earlier by the lag, and with a velocity that is the slope of this position over 10
/// samples, for z over 4.
FlightLog with_captured_velocity(FlightLog log, double lag_s);

/// Moves the position earlier by its lag behind the attitude, and leaves out the logged velocity, which may have
/// another delay. The lag is that of the heading of the same source (extra pose_yaw). 10 ms would make a drag of 0.30
/// 1/s look like 0.27. If the lag cannot be found, only a note is added; a log without these signals is unchanged.
FlightLog with_aligned_position(FlightLog log);

/// The series delayed by `samples` (negative: advanced), with linear interpolation; the end values are held.
std::vector<double> moved_later(const std::vector<double>& values, double samples);

}  // namespace m100::lab::logs
