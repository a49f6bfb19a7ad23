// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/axis/axis_blocks.h"
#include "host_tests/lab/identify/remainder/residual_test.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

/// Which signals of a log belong to a stick axis, and by which names a reader knows them.
struct AxisSignals {
  AxisData data;
  std::string stick_name;
  std::string other_name;  ///< empty: none
  std::string response_name;
  std::vector<Finding> findings;  ///< what of the log was left out, and why
};

/// Picks stick (or command in SI units), the other axis' stick and the measured response of `axis` out of a log. A
/// climb speed or yaw rate that was not logged is the slope of height or yaw.
/// @param asked  ranges outside of which spoilt samples do not matter; empty: none
/// @param stick_earlier_s  by which both sticks are moved, at least 0: for clocks that disagree
/// @throws InputError naming file and signal.
AxisSignals axis_signals(const logs::FlightLog& log, const std::string& axis, const std::vector<Range>& asked,
                         double stick_earlier_s = 0.0);

/// What the residual of this axis may depend on, over the samples [begin, end) of the log: lags, powers and products of
/// the sticks, time, and every extra channel. Only causes: a channel that the residual itself would move (rates,
/// velocities) proves nothing.
std::vector<RegressorGroup> axis_regressors(const logs::FlightLog& log, const AxisSignals& signals, std::size_t begin,
                                            std::size_t end);
/// How busy the sticks were: may explain the residual's size.
std::vector<RegressorGroup> axis_activity(const AxisSignals& signals, std::size_t begin, std::size_t end);

}  // namespace m100::lab::identify
