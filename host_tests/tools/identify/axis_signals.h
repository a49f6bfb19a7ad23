// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/tools/identify/axis_blocks.h"
#include "host_tests/tools/identify/residual_test.h"
#include "host_tests/tools/logs/flight_log.h"

namespace m100::tools::identify {

/// Which signals of a log belong to a stick axis, and by which names a reader knows them.
struct AxisSignals {
  AxisData data;
  std::string stick_name;
  std::string other_name;  ///< empty: none
  std::string response_name;
  std::vector<std::string> findings;  ///< what of the log was left out, and why
};

/// Picks stick (or command in SI units), the other axis' stick and the measured response of `axis` out of a log. A
/// climb speed or yaw rate that was not logged is the slope of height or yaw.
/// @throws InputError naming file and signal.
AxisSignals axis_signals(const logs::FlightLog& log, const std::string& axis);

/// What the residual of this axis may depend on, over the samples [begin, end) of the log: lags, powers and products of
/// the sticks, time, and every extra channel. Only causes: a channel that the residual itself would move (rates,
/// velocities) proves nothing.
std::vector<RegressorGroup> axis_regressors(const logs::FlightLog& log, const AxisSignals& signals, std::size_t begin,
                                            std::size_t end);
/// How busy the sticks were: may explain the residual's size.
std::vector<RegressorGroup> axis_activity(const AxisSignals& signals, std::size_t begin, std::size_t end);

}  // namespace m100::tools::identify
