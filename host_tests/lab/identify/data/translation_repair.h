// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify::translation {

/// The log with repaired samples: degrees converted to radians, outliers replaced, frozen samples of attitude, velocity
/// and position marked as gaps. Adds a finding for each repair and for each time on the ground.
/// @param requested  ranges outside of which spoilt samples do not matter; empty: all samples matter
logs::FlightLog repaired(const logs::FlightLog& log, const std::vector<Range>& requested,
                         std::vector<Finding>& findings);

/// Tests whether another interpretation of the attitude predicts the measured acceleration much better than that of the
/// column map: other signs, exchanged axes, or a heading turned by a quarter. "Much better" is at most half of the RMS
/// error, or at most 85 % of it and significantly smaller. The finding lists all interpretations that fit about equally
/// well. Another finding reports that attitude and acceleration differ in unit (degrees).
/// @returns nothing if no other interpretation is much better and the units agree, or if roll or pitch is not logged.
std::vector<Finding> misread_attitude(const logs::FlightLog& log, const std::vector<Range>& ranges);

}  // namespace m100::lab::identify::translation
