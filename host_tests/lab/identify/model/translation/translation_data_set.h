// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/data/translation_data.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify::translation {

/// Whether each flight of joined logs has its own wind, and which data give it (flight_winds.h).
struct FlightWindSource {
  bool own = false;     ///< from all blocks of the flight
  double head_s = 0.0;  ///< from its first seconds; 0: not
};

/// One log with its ranges divided into blocks. A series of rows has blocks.rows values (see TranslationBlocks).
struct TranslationDataSet {
  /// The log must outlive the part. @throws InputError as TranslationData does.
  TranslationDataSet(const logs::FlightLog& of, const std::vector<Range>& ranges, ThrustSource thrust,
                     FlightWindSource winds = {});
  TranslationDataSet(const TranslationDataSet&) = delete;
  TranslationDataSet& operator=(const TranslationDataSet&) = delete;

  /// Root mean square of measured minus predicted rows.
  double rmse(const std::vector<double>& predicted) const;
  /// 100 (1 - |error| / |measured - mean|), the mean of each axis by itself.
  double fit_percent(const std::vector<double>& predicted) const;
  /// Rows of one axis, block by block.
  std::vector<double> axis(const std::vector<double>& rows, std::size_t c) const;
  /// Root mean square error of the mean acceleration over each horizon: the error of the predicted velocity change
  /// divided by the horizon.
  HorizonErrors horizon_rmse(const std::vector<double>& predicted) const;

  const logs::FlightLog& log;
  TranslationData data;
  TranslationBlocks blocks;
  std::vector<double> measured;  ///< rows
};

/// Whether every log of the request has the signal.
bool both_have(const Request& request, logs::Signal signal);

/// The source of thrust: its set point if every log has it (kThrustRatio), or else what fits the training part best.
ThrustSource thrust_source(const Request& request);

}  // namespace m100::lab::identify::translation
