// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/axis/axis_study.h"

namespace m100::lab::identify {

// Several flights of one vehicle share its parameters, but not the neutral point of their sticks: battery, load and the
// pilot's own trim differ from flight to flight. One trim for all of them would be found as a change at their joint.

/// What is to be taken from the stick of one flight, in its unit, beside the trim that all flights share.
struct FlightTrim {
  Interval size;       ///< about the mean of all flights; 95 %, the spread over blocks
  bool known = false;  ///< the flight has blocks to see it in
};

/// The trims by which the flights of the study's log differ from their mean, under `fit`, asked in the training part. A
/// flight that stands in the validation part alone is judged with the mean: what was fitted there would be quoted too.
/// Cost: some forty simulations of each flight. @returns nothing for a log that is one flight.
std::vector<FlightTrim> flight_trims(const AxisStudy& study, const Fit& fit);

/// Whether one of them is worth a parameter of its own: beyond four standard errors and beyond the least trim that
/// means something.
bool differ(const AxisStudy& study, const std::vector<FlightTrim>& trims);

/// Whether the trims that are left beside those that were taken are still worth a second look: half a standard error.
bool moved(const AxisStudy& study, const std::vector<FlightTrim>& more);

/// One sentence for the report.
std::string in_words(const std::vector<FlightTrim>& trims);

}  // namespace m100::lab::identify
