// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify::translation {

/// The log with what is no measurement taken out: degrees turned into radians, outliers replaced, frozen samples of
/// attitude, velocity and position marked as gaps. Says so in `findings`.
/// @param asked  ranges outside of which spoilt samples do not matter; empty: none
logs::FlightLog repaired(const logs::FlightLog& log, const std::vector<Range>& asked, std::vector<Finding>& findings);

/// Whether another reading of the attitude predicts the measured acceleration much better than the column map's:
/// signs of roll and pitch, both exchanged, a heading of the other sign, quarter and half turns. A reading that is
/// right leaves a twentieth of the error; half of it is asked for. The heading's sign cannot be told where the heading
/// hardly changes: readings that are as good are listed in the text.
/// @returns nothing where the map's reading is the best, or no attitude is logged.
std::vector<Finding> misread(const logs::FlightLog& log, const std::vector<Range>& ranges);

}  // namespace m100::lab::identify::translation
