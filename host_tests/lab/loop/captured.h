// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::loop {

// What motion capture saw, at the time at which the autopilot felt it.

/// How much later the captured heading shows a turn than the autopilot's attitude does [s]: least squares over all
/// turns of the range, differences over 0.5 s, so that a heading that drifts does no harm. The two measure one and the
/// same angle, so that no model of the vehicle is needed, and half a minute of turns gives 0.2 ms. The age that the
/// observer believed is no substitute: it may be off by 20 ms, and a climb that is seen 10 ms too early looks like play
/// in the stick.
/// @param captured_heading_rad  one value for each sample of the log
/// @param otherwise_s           the answer where the heading hardly turned, or where the two disagree
double capture_lag_s(const logs::FlightLog& log, std::vector<double> captured_heading_rad,
                     std::pair<double, double> range_s, double otherwise_s);

/// The log with position earlier by the lag, and the velocity that follows from it instead of the one that the observer
/// believed: the slope over 0.1 s (upwards 0.04 s).
logs::FlightLog with_captured_velocity(logs::FlightLog log, double lag_s);

/// The values of so many samples ago (negative: of later ones), between samples by straight lines; the ends are held.
std::vector<double> moved_later(const std::vector<double>& values, double samples);

}  // namespace m100::lab::loop
