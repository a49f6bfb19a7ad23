// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/flight/flight_series.h"
#include "host_tests/lab/plot/html.h"

namespace m100::lab::flight {

/// The page of one flight, or of two on the same axes, before and after. First, on one screen: error with its interval,
/// failsafe, path with the fence, pose, commands, battery. Then the details (add_details()).
/// @param note a sentence about the origin of the flights; may be empty.
plot::Page flight_page(const std::vector<FlightSeries>& flights, const std::string& title, const std::string& note);

/// The first screen alone, for a page that shows more than a flight.
void add_first_screen(const std::vector<FlightSeries>& flights, plot::Page& page);

/// The errors in words: "Distance from the course: 0.031 m [0.027, 0.035] root mean square, ..."; of two: the change.
std::string error_sentence(const std::vector<FlightSeries>& flights);

}  // namespace m100::lab::flight
