// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::logs {

/// Compares the specific force with gravity and with the attitude. What is certainly no specific force in body axes is
/// left out of the log, with a note.
///
/// Over a flight, speeds stay bounded, so the mean specific force is gravity; an acceleration from which gravity was
/// subtracted has a mean near zero. The thrust lies along the body's z axis, so in body axes the horizontal parts do
/// not follow the tilt; in world axes they are gravity times the tilt. The limits are half way between the two.
void validate_force(FlightLog& log);

}  // namespace m100::lab::logs
