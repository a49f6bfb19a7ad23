// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::logs {

/// ArduPilot's self-describing binary log (".bin"). Columns are `ATT.Roll`, in the unit that the log's own multipliers
/// give (degrees stay degrees), and `IMU:1.GyrX` for the second instance; each message type has its own clock, in
/// seconds (`ATT.TimeUS`).
std::unique_ptr<RawLog> open_ardupilot(const std::string& file);

}  // namespace m100::lab::logs
