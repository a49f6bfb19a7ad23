// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "firmware/core/maths.h"
#include "host_tests/lab/flight/tracking.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::flight {

// Each function draws one flight, or two on the same axes. The time of one flight counts from the begin of its log, as
// in the lines that m100 prints; the time of two flights counts from where the law first flew in each.
using Flights = std::vector<FlightSeries>;

plot::Figure path_from_above(const Flights& flights);
/// Seen along the horizontal axis in which the flight is shorter.
plot::Figure path_from_the_side(const Flights& flights);
/// The least distance to a side of the fence, or that the log holds no fence, as a sentence; empty for a recording.
std::string fence_words(const FlightSeries& flight);
plot::Figure distance_figure(const Flights& flights);
plot::Figure failsafe_figure(const Flights& flights);
plot::Figure command_figure(const Flights& flights);
plot::Figure pose_figure(const Flights& flights);
plot::Figure battery_figure(const Flights& flights);
plot::Figure stick_figure(const Flights& flights);  ///< of two flights only the second

/// An empty figure over time with the failsafe's states behind it.
plot::Figure over_time(const Flights& flights, const std::string& title, const std::string& y_label);
/// Values over times of the log as a curve. tick_curve() takes one value for each tick.
/// @param name the curve's, without "before" and "after".
plot::Curve curve(const Flights& flights, std::size_t flight, const std::string& name, const std::vector<double>& t_s,
                  const std::vector<double>& values, const char* color, double scale);
plot::Curve tick_curve(const Flights& flights, std::size_t flight, const std::string& name,
                       const std::vector<double>& values, double scale, const char* color);
/// The errors of a flight against its course as a curve. @param value  what of an error is drawn.
plot::Curve error_curve(const Flights& flights, std::size_t flight, const std::string& name, const char* color,
                        const std::vector<TrackingError>& errors,
                        const std::function<double(const TrackingError&)>& value);
/// The time that a figure shows for a time of the log.
double shown_s(const Flights& flights, std::size_t flight, double t_s);
/// The prefix of a name: "before, " or "after, " with two flights, otherwise "".
std::string which(const Flights& flights, std::size_t flight);

}  // namespace m100::lab::flight
