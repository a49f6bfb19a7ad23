// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::logs {

/// Writes a log as CSV in canonical units: `t_s`, each of its signals by canonical name, each extra channel, and a
/// column `gap` if there are any. Each stretch has its own times, and pauses have no rows. Values have nine significant
/// digits, times fifteen. A signal in a gap is empty, so that it is again a gap when the file is read. @throws
/// InputError: cannot be written.
void write_csv(const FlightLog& log, const std::string& file);

/// Writes the column map with which a file of write_csv() is read back. @throws InputError: cannot be written.
void write_column_map(const FlightLog& log, const std::string& file);

}  // namespace m100::lab::logs
