// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ostream>
#include <string>

#include "firmware/app/tick_record.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/link/link_health.h"
#include "firmware/log/flight_log.h"

namespace m100::companion {

/// The health of a link as one JSON object, in SI units.
Json to_json(const link::LinkHealth& health);
/// Logs the health of the link, "link_health {...}" with most numbers of to_json(), and the vibration, once a second.
/// No heap. @param log  null: no log  @param logged_at  time of the last lines
void log_health(log::FlightLogWriter* log, const app::TickRecord<double>& record, core::TimePoint& logged_at);

/// The health of a link as a few lines for the operator.
void print(std::ostream& out, const link::LinkHealth& health);

/// Writes the result of a subcommand. Errors: UsageError naming the file and what is wrong.
void write_json(const std::string& path, const Json& result);
/// As write_json(), after a flight: an error goes to stderr and does not change the exit code. Empty path: nothing.
void write_result(const std::string& path, const Json& result);

}  // namespace m100::companion
