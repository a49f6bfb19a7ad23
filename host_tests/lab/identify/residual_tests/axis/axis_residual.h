// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/data/axis_signals.h"
#include "host_tests/lab/identify/model/axis/axis_family.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// Subtracts from the stick of each flight the trim of this flight. If `trims` is empty, it changes nothing.
AxisSignals without_trims(AxisSignals signals, const std::vector<double>& trims);

/// One log with its axis, its ranges and its blocks.
struct AxisDataSet {
  /// The log must outlive the part. @param requested  as for axis_signals
  /// @param trims  the trim of each flight of a joined log, subtracted from its stick; empty: none
  /// @throws InputError as axis_signals does.
  AxisDataSet(const logs::FlightLog& flight_log, const std::string& axis, const std::vector<Range>& given,
              const std::vector<Range>& requested, const StickClock& clock = {}, const std::vector<double>& trims = {})
      : AxisDataSet(
            flight_log,
            std::make_shared<const AxisSignals>(without_trims(axis_signals(flight_log, axis, requested, clock), trims)),
            given) {}
  /// Other ranges of the same log: the signals are shared with `other`.
  AxisDataSet(const AxisDataSet& other, const std::vector<Range>& given)
      : AxisDataSet(other.log, other.shared_signals_, given) {}
  AxisDataSet(const AxisDataSet&) = delete;
  AxisDataSet& operator=(const AxisDataSet&) = delete;

  const logs::FlightLog& log;
  const AxisSignals& signals;
  std::vector<Range> ranges;
  AxisBlocks blocks;

 private:
  AxisDataSet(const logs::FlightLog& flight_log, std::shared_ptr<const AxisSignals> own,
              const std::vector<Range>& given)
      : log(flight_log), signals(*own), ranges(given), blocks(signals.data, given), shared_signals_(std::move(own)) {}

  std::shared_ptr<const AxisSignals> shared_signals_;  ///< an hour of them takes 9 MB
};

/// The fit's structure fitted to `ranges` of the part's log.
model::StickAxis fitted_to(const AxisDataSet& part, const std::vector<Range>& ranges, const AxisFamily& family,
                           const Fit& fit);

/// Tests whether the residual of the final model, in free runs over both parts, is still predictable.
/// Preconditions: both parts are of the request and have at least one block each.
/// @returns sentences; empty: the residual is not predictable.
std::vector<std::string> residual_findings(const Request& request, const AxisDataSet& training,
                                           const AxisDataSet& validation, const model::StickAxis& model);

/// Root mean square of the residual where the stick has rested for 1 s: the error that air and autopilot cause.
/// @param minimum_counts  a stick that moves by less than three of these rests
/// @returns 0 where these samples last 2 s or less in all.
double noise_floor_at_rest(const AxisDataSet& part, const model::StickAxis& model, double minimum_counts);

/// Possible error of the simulated response, in size, because the stick between its rows is unknown. For each sample of
/// the ranges' blocks in turn it is the larger difference to the responses with the two sticks of hold_between_rows().
/// For a stick with rows of at most 1.5 samples it is the difference to the response with the stick half a row earlier.
std::vector<double> intersample_error(const AxisData& data, const std::vector<Range>& ranges,
                                      const model::StickAxis& model, double block_s = AxisBlocks::kBlock_s);

/// One extreme of the unknown stick between its rows: held at the last row or, with `next`, already at the next. In
/// rows of at most a sample, a value between its two neighbours becomes the value before it or, with `next`, after it.
AxisData hold_between_rows(AxisData data, bool next);
/// Whether the stick was logged in rows further apart than samples.
inline bool is_stick_undersampled(const AxisData& data) { return data.stick_row_s > 1.5 * data.period_s; }

}  // namespace m100::lab::identify
