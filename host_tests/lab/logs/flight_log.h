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
  int rate_shift_samples = 0;   ///< likewise for the body rates
  /// "sequence": message counters; "correlation": the rates against the change of the attitude; "none": the log's clock
  /// was taken as common, because a shift of the sticks cannot be distinguished from transport delay.
  std::string evidence = "none";
};

/// One of several logs that were joined, or a stretch of a log (stretches.h).
struct Flight {
  std::string file;
  std::size_t begin = 0, end = 0;  ///< its samples [begin, end) of the whole log
  double start_s = 0.0;            ///< time on its own clock at `begin`
  double epoch_s = 0.0;            ///< see FlightLog
};

/// A log on a uniform clock, in canonical units. Sample k was taken at start_s + k * period_s.
struct FlightLog {
  std::string file;
  std::string columns;  ///< the file of the column map
  double start_s = 0;
  double epoch_s = 0;  ///< seconds that count_from_begin() subtracted from the log's own clock
  double period_s = 0.01;
  std::size_t size = 0;
  std::array<std::vector<double>, kSignals> signals;  ///< empty: the log does not have the signal; yaw is unwrapped
  std::map<std::string, std::vector<double>> extra;
  std::vector<std::uint8_t> gap;  ///< 1: some mapped signal was not sampled here; its value is interpolated or held
  std::map<Signal, std::vector<std::uint8_t>> signal_gap;  ///< the gaps of each signal that has any
  std::map<Signal, double> row_s;                          ///< interval of a signal's own rows, if it was resampled
  double velocity_mean_s = 0.0;  ///< the horizontal velocity is its mean over this time; 0: as measured
  Alignment alignment;
  std::vector<std::string> notes;      ///< findings of the reader: repeated time stamps, shifts, what was left out
  std::vector<std::string> gap_notes;  ///< about samples that are missing or cannot be used, which `gap` holds too
  std::vector<Flight> flights;         ///< the joined logs and stretches, two or more; otherwise empty

  bool has(Signal signal) const { return !of(signal).empty(); }
  bool has3(Signal first) const { return has(first) && has(offset(first, 1)) && has(offset(first, 2)); }
  const std::vector<double>& of(Signal signal) const { return signals[static_cast<std::size_t>(signal)]; }
  std::vector<double>& of(Signal signal) { return signals[static_cast<std::size_t>(signal)]; }
  /// Seconds between the logged rows of a signal; between rows it is interpolated linearly.
  double logged_row_of(Signal signal) const { return row_s.contains(signal) ? row_s.at(signal) : period_s; }
  double row_of(Signal signal) const { return std::max(period_s, logged_row_of(signal)); }
  /// The flights, or the whole log as one.
  std::vector<Flight> parts() const {
    return flights.empty() ? std::vector<Flight>{{file, 0, size, start_s, epoch_s}} : flights;
  }
  double time_s(std::size_t k) const { return start_s + static_cast<double>(k) * period_s; }
  /// Index of the first sample at or after a time, at most size.
  std::size_t index_of(double time_s) const;
  /// 1 where one of these signals was not sampled. For a log without signal_gap this is `gap` for all signals.
  std::vector<std::uint8_t> gap_of(std::initializer_list<Signal> wanted) const;
};

/// Reads, scales, rotates into north-west-up and forward-left-up, aligns and resamples one log. Quaternions become
/// angles. The stretches of the map's clock become flights with a pause between them, as in a joined log; stretches of
/// fewer than 16 samples are left out. Cost: linear in the log's length.
/// @throws InputError: as column() of the raw log; a clock that runs backwards, or another that is set back;
///   streams of different lengths; fewer than 16 samples.
FlightLog load(const RawLog& raw, const ColumnMap& map, double period_s = 0.01);

/// Opens `file` and loads it with the column map that the file `columns` holds.
FlightLog load(const std::string& file, const std::string& columns, double period_s = 0.01);

}  // namespace m100::lab::logs
