// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <netinet/in.h>

#include <optional>
#include <string>

#include "firmware/app/tick_record.h"

namespace m100::companion {

class Subcommand;

/// What the operator wants to see during the flight.
struct LiveOptions {
  std::string to;               ///< "HOST:PORT" that receives the JSON; empty: none
  std::string status = "auto";  ///< auto: if the standard output is a terminal; always, never
};

void add_live_options(const Subcommand& app, LiveOptions& options);

/// Whether the terminal shows a status line.
bool shows_status(const LiveOptions& options);

/// Parses an IPv4 address and a port; empty text: nullopt. Errors: UsageError if it is neither.
std::optional<sockaddr_in> receiver_of(const std::string& text);

/// One object of JSON, as PlotJuggler's UDP server takes it; its `timestamp` is the tick's time in seconds.
std::string json_of(const app::TickRecord<double>& record);
/// One line: failsafe state, position, distance from the course, latency and loss of the poses, link. @param
/// lost_share lost poses over sent ones.
std::string status_of(const app::TickRecord<double>& record, double lost_share);

}  // namespace m100::companion
