// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::logs {

/// If no counter aligns gyro and attitude, compares rate_x with the rate about the body's x axis that the attitude
/// shows, roll' - yaw' sin(pitch); without pitch or yaw in the log, roll'. If they correlate by 0.8 or more at a shift
/// of at most 0.5 s, all three rates are shifted, with an entry in the log's alignment and notes.
void align_rates(FlightLog& log);

}  // namespace m100::lab::logs
