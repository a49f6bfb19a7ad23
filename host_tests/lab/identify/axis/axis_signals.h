// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/identify/answer/result.h"
#include "host_tests/lab/identify/axis/axis_blocks.h"
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

/// Central difference over +-5 samples: the noise of a position divided by ten sample periods.
std::vector<double> slope(const std::vector<double>& values, double period_s);

}  // namespace m100::lab::identify
