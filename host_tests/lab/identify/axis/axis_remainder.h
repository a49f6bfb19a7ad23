// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/identify/axis/axis_family.h"
#include "host_tests/lab/identify/axis/axis_signals.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// The signals with a trim taken from the stick of each flight; no trims: as they are.
AxisSignals without_trims(AxisSignals signals, const std::vector<double>& trims);

/// One log with its axis, its ranges and its blocks.
struct AxisPart {
  /// The log must outlive the part. @param asked  as for axis_signals
  /// @param stick_earlier_s  by which the sticks are moved before anything else
  /// @param trims  of each flight of a joined log, taken from its stick; empty: none
  /// @throws InputError as axis_signals does.
  AxisPart(const logs::FlightLog& flight_log, const std::string& axis, const std::vector<Range>& given,
           const std::vector<Range>& asked, double stick_earlier_s = 0.0, const std::vector<double>& trims = {})
      : log(flight_log),
        signals(without_trims(axis_signals(flight_log, axis, asked, stick_earlier_s), trims)),
        ranges(given),
        blocks(signals.data, given) {}
  AxisPart(const AxisPart&) = delete;
  AxisPart& operator=(const AxisPart&) = delete;

  const logs::FlightLog& log;
  AxisSignals signals;
  std::vector<Range> ranges;
  AxisBlocks blocks;
};

/// What the final model leaves of both parts as free runs, tested for what may still predict it.
/// Preconditions: both parts are of the request and have at least one block each.
/// @returns sentences; empty: nothing that could be predicted is left.
std::vector<std::string> remainder_of(const Request& request, const AxisPart& training, const AxisPart& validation,
                                      const model::StickAxis& model);

/// Root mean square of the residual where the stick has rested for the model's memory: what air and autopilot leave.
/// @param minimum_counts  a stick that moves by less than three of these rests
/// @returns 0 where the stick hardly ever rested.
double quiet_floor(const AxisPart& part, const model::StickAxis& model, double minimum_counts);

/// By how much the response of each sample of the ranges' blocks, one after the other, may be off because nobody knows
/// the stick between its rows: the larger difference to the two sticks of held_between_rows(). Nought where it is
/// known.
std::vector<double> unknown_between_rows(const AxisData& data, const std::vector<Range>& ranges,
                                         const model::StickAxis& model, double block_s = AxisBlocks::kBlock_s);

/// The stick as it may have been between its rows, where it was held: at its next or at its last row all the way.
AxisData held_between_rows(AxisData data, bool next);
/// Whether the stick was logged in rows further apart than samples.
inline bool slow_rows(const AxisData& data) { return data.stick_row_s > 1.5 * data.period_s; }

}  // namespace m100::lab::identify
