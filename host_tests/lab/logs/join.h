// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/logs/stretches.h"

namespace m100::lab::logs {

/// If a log's clock starts at 10^7 s (116 days) or more, it counts from another epoch: subtracts whole seconds, so that
/// times can be read, and says so in a note.
void count_from_begin(FlightLog& log);

/// Joins several logs, with a pause between them that is longer than any model's memory. The pause is a gap in which
/// every signal has the first value of the next log. Signals and extra channels that one of the logs lacks are left
/// out. A single log is unchanged, but for notes on its stretches, each of which counts as a log. Preconditions: at
/// least one log; equal periods and velocity means.
FlightLog joined(std::vector<FlightLog> logs);
/// The placed stretches as flights of the log; none if there is one only.
std::vector<Flight> flights_of(const std::vector<Stretch>& stretches, const std::string& file, const FlightLog& log);
/// In a pause nothing is sampled; each signal has the first value of the next stretch, as between joined logs.
void fill_pauses(FlightLog& log);
/// Marks in `gap` what `more`, of the same length, marks.
void add_gaps(std::vector<std::uint8_t>& gap, const std::vector<std::uint8_t>& more);
/// Notes how many samples are missing, without the pauses.
void note_gaps(FlightLog& log);
/// Converts `own_s`, on the clock of log number `flight` (from 0; 0 for a single log), to the joined log's clock.
double joined_time(const FlightLog& log, std::size_t flight, double own_s);
/// The time as text, on the clock of the log in which it lies: "12.30 s", in a joined log "2@12.30 s".
std::string place_of(const FlightLog& log, double time_s);

}  // namespace m100::lab::logs
