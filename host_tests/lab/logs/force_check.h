// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::logs {

/// Leaves the force out of the log, with a note, if it is certainly no specific force in body axes.
///
/// The mean specific force of a flight is gravity. If the mean is near zero, gravity was subtracted. The thrust lies
/// along the body's z axis, so in body axes the horizontal parts do not follow the tilt. If they do, the force is in
/// world axes.
void validate_force(FlightLog& log);

}  // namespace m100::lab::logs
