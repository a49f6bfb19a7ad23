// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::logs {

/// Compares the gyro with the rate of the attitude. If no counter aligns them, finds and removes their shift, and says
/// so in the log's alignment and notes.
void align_rates(FlightLog& log);

}  // namespace m100::lab::logs
