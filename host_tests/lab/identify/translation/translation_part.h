// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/translation/translation_data.h"

namespace m100::lab::identify::translation {

/// Whether the flights of joined logs have winds of their own, and where those are taken from (flight_winds.h).
struct WindOfFlight {
  bool own = false;     ///< from all blocks of the flight
  double head_s = 0.0;  ///< from so many seconds at its begin; 0: not
};

/// One log with its ranges cut into blocks. A series of rows has blocks.rows values (see TranslationBlocks).
struct Part {
  /// The log must outlive the part. @throws InputError as TranslationData does.
  Part(const logs::FlightLog& of, const std::vector<Range>& ranges, Thrust thrust, WindOfFlight winds = {});
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  /// Root mean square of measured less predicted rows.
  double rmse(const std::vector<double>& predicted) const;
  /// 100 (1 - |error| / |measured - mean|), the mean of each axis by itself.
  double fit_percent(const std::vector<double>& predicted) const;
  /// Rows of one axis in time order.
  std::vector<double> axis(const std::vector<double>& rows, std::size_t c) const;
  /// How wrong the mean acceleration over a horizon is: the error of the predicted velocity change over its time.
  std::vector<std::pair<double, double>> horizon_rmse(const std::vector<double>& predicted,
                                                      const std::vector<double>& horizons_s) const;

  const logs::FlightLog& log;
  TranslationData data;
  TranslationBlocks blocks;
  std::vector<double> measured;  ///< rows
};

/// Whether every log of the request has the signal.
bool both_have(const Request& request, logs::Signal signal);

/// Where thrust comes from in this log: a set point, else what the training part itself prefers.
Thrust thrust_source(const Request& request);

}  // namespace m100::lab::identify::translation
