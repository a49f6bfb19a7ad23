// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::logs {

/// Writes a log as CSV in canonical units: `t_s`, each signal it has by its canonical name, each extra channel, and
/// `gap` where there are any. Nine significant digits, of the time fifteen. A cell of a gap is empty, so that it is a
/// gap when the file is read again. @throws InputError: cannot be written.
void write_csv(const FlightLog& log, const std::string& file);

/// The column map that reads such a file back. @throws InputError: cannot be written.
void write_column_map(const FlightLog& log, const std::string& file);

}  // namespace m100::lab::logs
