// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/flight/flight_series.h"
#include "host_tests/lab/plot/html.h"

namespace m100::lab::flight {

/// The page of one flight, or of two on the same axes, before and after. First, on one screen: error with its interval,
/// failsafe, path with the fence, pose, commands, battery. Then the details: error by axis, attitude, disturbance as
/// estimated in flight and as found from the log, prediction, residual.
/// @param note a sentence about the origin of the flights; may be empty.
plot::Page flight_page(const std::vector<FlightSeries>& flights, const std::string& title, const std::string& note);

/// The first screen alone, for a page that shows more than a flight.
void add_first_screen(const std::vector<FlightSeries>& flights, plot::Page& page);

/// The errors in one sentence: "0.031 m root mean square [0.027, 0.035], ..." or the difference of two flights.
std::string error_sentence(const std::vector<FlightSeries>& flights);

}  // namespace m100::lab::flight
