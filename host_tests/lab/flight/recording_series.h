// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/flight/flight_series.h"
#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::flight {

/// The series of a recording of `m100 record`: sticks, attitude, poses and battery of a flight by hand.
FlightSeries recording_series(const logs::RawLog& raw, const std::string& name);

}  // namespace m100::lab::flight
