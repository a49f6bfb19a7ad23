// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/flight/flight_series.h"

namespace m100::lab::flight {

/// Predicts the flight by the vehicle file that its log holds (identify::predict), and adds the errors. Nothing is
/// added to a flight without sticks of its own (a recording, or a flight by movement control) or of less than 6 s.
void add_predictions(const std::string& file, FlightSeries& flight);

}  // namespace m100::lab::flight
