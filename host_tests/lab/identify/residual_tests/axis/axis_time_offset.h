// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/identify/model/axis/axis_family.h"
#include "host_tests/lab/identify/model/axis/free_run.h"

namespace m100::lab::identify {

/// Whether the response begins before its stick. Then the clocks of the log disagree, and a lead zero found by the
/// selection is a side effect of the shift.
struct TimeOffset {
  bool likely = false;      ///< a shift is likelier than none, and larger than unknown times of the steps explain
  bool certain = false;     ///< no times of the stick's steps within their rows explain the shift
  bool within_row = false;  ///< a shift may be there, but a stick that moved early in each of its rows explains it
  /// The fit has a lead zero, and an early response without a lead zero is not clearly less likely.
  bool zero_in_doubt = false;
  double shift_s = 0.0;  ///< net delay of the response, below zero
  double sigma_s = 0.0;
  double likelihood_ratio = 0.0;  ///< over the best model whose response does not begin before its stick
};

/// Compares three whitened fits of the final model: with a delay that may be negative, with a lead zero and a delay of
/// at least zero, and with a lead zero and a delay that may be negative. A shift can only be seen if the net delay
/// becomes negative; otherwise it is indistinguishable from a delay. Precondition: the fit is of `family`. Cost: at
/// most five fits of free runs; none if the delay is clear.
TimeOffset time_offset(const FreeRun& run, const AxisFamily& family, const Fit& fit);

/// A sentence about a likely shift.
std::string describe(const TimeOffset& clock);

}  // namespace m100::lab::identify
