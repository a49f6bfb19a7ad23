// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "host_tests/lab/identify/model/axis/axis_blocks.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::lab::identify {

/// The signals of a log that belong to a stick axis, and their names in reports.
struct AxisSignals {
  AxisData data;
  std::string stick_name;
  std::string other_name;  ///< empty: none
  std::string response_name;
  std::vector<Finding> findings;  ///< defects of the log: what was excluded or repaired, and why
};

/// The clock of the sticks against that of the response.
struct StickClock {
  double earlier_s = 0.0;  ///< time by which both sticks are shifted earlier, at least 0
  double rate = 0.0;       ///< seconds per second by which they are shifted more from sample to sample
};
/// The series read at other times: sample i at i + earlier + rate * (i - its middle), interpolated linearly. Beyond the
/// ends the first and the last value are held. @param earlier  in samples
void read_at_times(std::vector<double>& values, double earlier, double rate);

/// Takes the stick (or command in SI units), the other axis' stick and the measured response of `axis` from a log. A
/// climb speed or yaw rate that was not logged is computed as the derivative() of height or yaw.
/// @param requested  ranges outside of which spoilt samples do not matter; empty: all samples matter
/// @throws InputError naming file and signal.
AxisSignals axis_signals(const logs::FlightLog& log, const std::string& axis, const std::vector<Range>& requested,
                         const StickClock& clock = {});

/// Central difference over +-5 samples, i.e. over ten sample periods; over fewer at the ends. At 100 Hz it attenuates
/// an oscillation of 6 rad/s by 1.5 %.
double central_difference(const std::vector<double>& values, std::size_t sample, double period_s);
/// Derivative by a cubic fitted to each sample and nine on either side (Savitzky-Golay); near the ends the central
/// difference. At 100 Hz it attenuates an oscillation of 6 rad/s by less than 0.1 %.
std::vector<double> derivative(const std::vector<double>& values, double period_s);

}  // namespace m100::lab::identify
