// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <vector>

#include "host_tests/lab/logs/column_map.h"
#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::logs {

/// How the streams of a log were brought onto one clock.
struct Alignment {
  int stick_shift_samples = 0;  ///< samples by which the sticks had to be moved later (negative: earlier)
  int rate_shift_samples = 0;   ///< the same for the body rates
  /// "sequence": message counters; "correlation": the rates against the turning attitude; "none": one clock was
  /// believed, and a shift of the sticks could not be told from transport delay.
  std::string evidence = "none";
};

/// One of several logs that were joined.
struct Flight {
  std::string file;
  std::size_t begin = 0, end = 0;  ///< its samples [begin, end) of the joined log
  double start_s = 0.0;            ///< of its own clock, at `begin`
  Alignment alignment;
};

/// A log on a uniform clock, in canonical units. Sample k was taken at start_s + k * period_s of the log's own time.
struct FlightLog {
  std::string file;
  double start_s = 0;
  double period_s = 0.01;
  std::size_t size = 0;
  std::array<std::vector<double>, kSignals> signals;  ///< empty where the log has none; yaw is unwrapped
  std::map<std::string, std::vector<double>> extra;
  std::vector<std::uint8_t> gap;  ///< 1: some mapped signal was not sampled here; its value is interpolated or held
  std::map<Signal, std::vector<std::uint8_t>> signal_gap;  ///< the same of each signal that has any
  std::map<Signal, double> row_s;                          ///< between a signal's own rows, where it was resampled
  double velocity_mean_s = 0.0;  ///< the horizontal velocity is its own mean over so long; 0: as it was measured
  Alignment alignment;
  std::vector<std::string> notes;  ///< findings of the reader: repeated stamps, dropouts, shifts
  std::vector<Flight> flights;     ///< of a joined log: two or more; else empty

  bool has(Signal signal) const { return !of(signal).empty(); }
  bool has3(Signal first) const { return has(first) && has(offset(first, 1)) && has(offset(first, 2)); }
  const std::vector<double>& of(Signal signal) const { return signals[static_cast<std::size_t>(signal)]; }
  std::vector<double>& of(Signal signal) { return signals[static_cast<std::size_t>(signal)]; }
  /// Seconds between the rows in which a signal was logged, at least a period: what lies in between is a straight line.
  double row_of(Signal signal) const {
    const auto found = row_s.find(signal);
    return found == row_s.end() ? period_s : std::max(period_s, found->second);
  }
  double time_s(std::size_t k) const { return start_s + static_cast<double>(k) * period_s; }
  /// Sample at or after a time, at most size.
  std::size_t index_of(double time_s) const;
  /// 1 where one of these signals was not sampled. A log made without signal_gap has one answer for all: gap.
  std::vector<std::uint8_t> gap_of(std::initializer_list<Signal> wanted) const;
};

/// Reads, scales, turns into north-west-up and forward-left-up, aligns and resamples one log. Quaternions become
/// angles. Cost: linear in the log's length.
/// @throws InputError: whatever column() of the raw log throws; a clock that runs backwards; streams whose lengths do
///   not agree; fewer than 16 samples.
FlightLog load(const RawLog& raw, const ColumnMap& map, double period_s = 0.01);

/// Opens and loads. @param columns the map's file.
FlightLog load(const std::string& file, const std::string& columns, double period_s = 0.01);

/// Several logs one behind the other, with a pause between them that is longer than anything remembers: a gap, in which
/// every signal has the value with which the next log begins. Signals and extra channels that one of them lacks are
/// left out. One log stays as it is. Precondition: at least one; equal periods.
FlightLog joined(std::vector<FlightLog> logs);

/// Time of the joined log's clock at `own_s` of the clock of its log number `flight` (from 0; 0 for a log alone).
double joined_time(const FlightLog& log, std::size_t flight, double own_s);
/// The clock of the log in which this moment lies: "12.30 s", in a joined log "2@12.30 s".
std::string place_of(const FlightLog& log, double time_s);

/// Lag d (samples) at which b[k - d] follows a[k] best, by normalised cross-correlation of the mean-free signals over
/// |d| <= most; peak: its correlation. d > 0: b must be moved later.
struct Lag {
  int samples = 0;
  double peak = 0;
};
Lag best_lag(const std::vector<double>& a, const std::vector<double>& b, int most);

}  // namespace m100::lab::logs
