// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "host_tests/lab/identify/model/whitening.h"

namespace m100::lab::identify {

// Finds the time at which a parameter takes another value. Shared by the stick axes and by translation.

/// Residual of a model and its derivatives by the parameters, row by row. A row is a mean over 50 ms or more of a stick
/// axis, or every third sample of 40 ms of translation, whose axes follow one another, each with its own segments.
struct ScanRows {
  std::vector<double> time_s;  ///< of each row; ascending within a segment
  std::vector<Segment> segments;
  Rows residual;
  Columns base;  ///< sensitivities of the model's own parameters: a residual that they explain is no change
  Rows weights;  ///< of the innovations, one for each row; empty: equal weights
};

/// The best time of a change of one parameter (or of two together).
struct ScanHit {
  double at_s = 0.0;
  double low_s = 0.0;  ///< interval of at_s: its likelihood ratios are within 7.35 of the best
  double high_s = 0.0;
  double likelihood_ratio = 0.0;
  Rows size;  ///< of the change, one for each column, in the column's unit
};

/// Finds the likeliest time tau of a change, in the middle 80 % of the log. Its likelihood ratio is -N ln(1 - share of
/// the whitened residual that columns 1[t > tau] explain in addition to the base columns). The autoregression is that
/// of a fit with the change, because that of a fit without it would absorb a step.
/// @param columns  residual rows x 1 or 2: sensitivity of the parameter over the whole log
/// @returns a ratio of 0 for fewer than 40 rows. Precondition: shapes agree. Cost: 50 whitenings, passes over the rows.
ScanHit scan_change(const ScanRows& rows, const Columns& columns);

}  // namespace m100::lab::identify
