// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/flight/flight_series.h"
#include "host_tests/lab/plot/html.h"

namespace m100::lab::flight {

/// The part below the first screen: notes, steps of the failsafe, prediction, error by axis, attitude, battery,
/// disturbance as estimated in flight and as found from the log, residual, timing, sticks.
void add_details(const std::vector<FlightSeries>& flights, plot::Page& page);

}  // namespace m100::lab::flight
