// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::logs {

// Aligns motion capture with the autopilot's measurements.

/// Delay of the captured heading after the autopilot's attitude [s]: least squares over all turns of the range, with
/// differences over 0.5 s, so that a drifting heading does not matter. Both measure the same angle, so no model of the
/// vehicle is needed, and half a minute of turns gives 0.2 ms. The age that the observer assumes is no substitute: it
/// may be wrong by 20 ms, and a climb that is seen 10 ms too early looks like backlash of the stick.
/// @param captured_heading_rad  one value for each sample of the log
/// @param otherwise_s           result where a heading is missing or hardly turned, or the lag would exceed 0.2 s
double capture_lag_s(const FlightLog& log, std::vector<double> captured_heading_rad, std::pair<double, double> range_s,
                     double otherwise_s);

/// The log with position shifted earlier by the lag, and with the velocity computed from it instead of the observer's:
/// its slope over 10 samples (z: 4), 0.1 s at 100 Hz.
FlightLog with_captured_velocity(FlightLog log, double lag_s);

/// Moves the position earlier by its lag behind the attitude, found in the heading of the same source (extra pose_yaw).
/// A source that is only recorded stamps its poses late by an unknown constant, and a lag of T looks like a drag that
/// is smaller by T w^2, w the frequency of the motion [rad/s]: 10 ms made 0.27 1/s of 0.30. Then the autopilot's own
/// velocity is left out, because it may read zero and has another delay. Adds a note about the lag; only a note if it
/// is unknown.
FlightLog with_aligned_position(FlightLog log);

/// The series delayed by `samples` (negative: advanced), with linear interpolation; the end values are held.
std::vector<double> moved_later(const std::vector<double>& values, double samples);

}  // namespace m100::lab::logs
