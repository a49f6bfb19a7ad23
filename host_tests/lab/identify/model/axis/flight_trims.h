// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/identify/axis_problem.h"
#include "host_tests/lab/identify/output/result.h"

namespace m100::lab::identify {

// Several flights of one vehicle share its parameters, but not the neutral point of their sticks: battery, load and the
// pilot's own trim differ from flight to flight. With one trim for all, that would look like a change.

/// Trim of one flight relative to the trim that all flights share, in the unit of the stick.
struct FlightTrim {
  Interval size;       ///< deviation from the mean of the known flights, with its 95 % interval
  bool known = false;  ///< the flight has at least two training blocks
};

/// Estimates the deviations of the flights' trims from their mean, with the model of `fit`, in the training part. A
/// flight that is only in the validation part gets none: its validation error must not depend on its own data.
/// Cost: some forty simulations of each flight. @returns an empty vector for a log of one flight.
std::vector<FlightTrim> flight_trims(const AxisProblem& problem, const Fit& fit);

/// Whether any flight's deviation is larger than four standard errors and six counts, and so needs its own parameter.
bool are_distinct(const AxisProblem& problem, const std::vector<FlightTrim>& trims);

/// Whether any deviation in `more` is larger than half a standard error and one count, and needs another iteration.
bool moved(const AxisProblem& problem, const std::vector<FlightTrim>& more);

/// The trims in one sentence for the report.
std::string describe(const std::vector<FlightTrim>& trims);

}  // namespace m100::lab::identify
