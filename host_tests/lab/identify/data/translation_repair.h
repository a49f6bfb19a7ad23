// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify::translation {

/// The log with repaired samples: degrees converted to radians, outliers replaced, frozen samples of attitude, velocity
/// and position marked as gaps. Adds a finding for each repair.
/// @param requested  ranges outside of which spoilt samples do not matter; empty: none
logs::FlightLog repaired(const logs::FlightLog& log, const std::vector<Range>& requested,
                         std::vector<Finding>& findings);

/// Tests whether another interpretation of the attitude predicts the measured acceleration much better than the column
/// map's: signs of roll and pitch, both exchanged, a heading of the other sign, quarter and half turns. The correct one
/// leaves a twentieth of the error; the threshold is half of it, or a significant difference of 15 %. The sign of the
/// heading cannot be found where the heading hardly changes: interpretations that fit equally well are listed in the
/// text.
/// @returns nothing where the map's interpretation is the best, or no attitude is logged.
std::vector<Finding> misread_attitude(const logs::FlightLog& log, const std::vector<Range>& ranges);

}  // namespace m100::lab::identify::translation
